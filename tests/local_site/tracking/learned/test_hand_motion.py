"""Landmarks are expected at constant velocity, and only where they move slowly."""

import numpy as np
import pytest

from local_site.tracking.learned.hand_motion import MOST_STEP_M, HandMotion

PERIOD_NS = 33_333_333
HAND = np.random.default_rng(0).normal(0.0, 0.05, (21, 3))
SLOW = 0.5 * MOST_STEP_M


def after(*steps_m):
    """What is known of a hand that has moved so far along x from instant to instant."""
    motion, moved = HandMotion(), HAND.copy()
    for k, step in enumerate((0.0, *steps_m)):
        moved = moved + np.array([step, 0.0, 0.0])
        motion.add(k * PERIOD_NS, moved)
    return motion


def test_the_next_instant_continues_the_last_step():
    last, now = after(0.0, SLOW).expected(3 * PERIOD_NS)
    assert np.allclose(now - last, [SLOW, 0.0, 0.0])
    assert np.allclose(last, HAND + np.array([SLOW, 0.0, 0.0]))


def test_a_longer_wait_takes_the_hand_further():
    last, now = after(0.4 * SLOW).expected(3 * PERIOD_NS)
    assert np.allclose(now - last, [0.8 * SLOW, 0.0, 0.0])


@pytest.mark.parametrize("step_m", [1.1 * MOST_STEP_M, -1.1 * MOST_STEP_M])
def test_a_fast_hand_is_not_expected_anywhere(step_m):
    assert after(step_m).expected(2 * PERIOD_NS) is None


def test_one_fast_finger_is_enough():
    motion, bent = HandMotion(), HAND.copy()
    motion.add(0, HAND)
    bent[8, 1] += 1.1 * MOST_STEP_M
    motion.add(PERIOD_NS, bent)
    assert motion.expected(2 * PERIOD_NS) is None


def test_two_instants_are_needed_again_after_a_loss():
    motion = after(SLOW)
    motion.forget()
    assert motion.expected(3 * PERIOD_NS) is None
    motion.add(3 * PERIOD_NS, HAND)
    assert motion.expected(4 * PERIOD_NS) is None


def test_an_instant_that_is_not_later_expects_nothing():
    assert after(SLOW).expected(PERIOD_NS) is None
