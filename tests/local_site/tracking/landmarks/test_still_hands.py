"""What looks like a hand is a picture of one when it has stood still for long; a live hand never does."""

import numpy as np
import pytest

from common.clock import NS_PER_S
from local_site.tracking.landmarks.still_hands import STILL_NS, StillHands
from tests.local_site.tracking.landmarks.scripted_hands import PERIOD_NS
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG, landmarks_of, seen_by
from tests.local_site.tracking.silhouette.hand_model.posed_hands import pose_of

HAND = landmarks_of(pose_of())
ELSEWHERE = (0.0, 0.05, 0.25)
LONG = STILL_NS // PERIOD_NS + 2


def seen(at=(0.0, 0.0, 0.0), view=0):
    return seen_by(PAIR_RIG.cameras[view], HAND + np.asarray(at))


def are_still(still, instants, hands, since=0):
    """Whether all are still at the last of some instants; `hands` gives by view those of an instant."""
    return [still.are_all((since + k) * PERIOD_NS, hands(k)) for k in range(instants)][-1]


def test_without_hands_nothing_moves():
    assert StillHands().are_all(0, [[], []])


def test_a_poster_is_still_after_a_while():
    still = StillHands()
    assert not are_still(still, LONG - 3, lambda _: [[seen()], []])
    assert are_still(still, 5, lambda _: [[seen()], []], since=LONG - 3)


def test_noise_of_landmarks_is_no_motion():
    random = np.random.default_rng(1)
    assert are_still(StillHands(), LONG, lambda _: [[seen(random.normal(0.0, 0.0005, 3))], []])


@pytest.mark.parametrize("speed", [0.01, 0.1, 1.0])
def test_a_hand_that_drifts_is_never_still(speed):
    still = StillHands()
    step = speed * PERIOD_NS / NS_PER_S
    for k in range(3 * LONG):
        assert not still.are_all(k * PERIOD_NS, [[seen((k * step, 0.0, 0.0))], []])


def test_a_hand_that_comes_in_beside_a_poster_counts():
    still = StillHands()
    assert are_still(still, LONG, lambda _: [[seen()], [seen(view=1)]])
    assert not still.are_all(LONG * PERIOD_NS, [[seen(), seen(ELSEWHERE)], [seen(view=1)]])
    assert still.are_all((LONG + 1) * PERIOD_NS, [[seen()], [seen(view=1)]])


def test_a_poster_that_is_not_seen_now_and_then_stays_one():
    assert are_still(StillHands(), 3 * LONG + 1, lambda k: [[seen()] if k % 3 == 0 else [], []])


def test_each_view_has_its_own_places():
    still = StillHands()
    assert are_still(still, LONG, lambda _: [[seen()], []])
    assert not still.are_all(LONG * PERIOD_NS, [[], [seen()]])
