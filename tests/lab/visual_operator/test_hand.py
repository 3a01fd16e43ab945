"""The scripted hand keeps a person's limits, and trembles as much as it should."""

import itertools

import numpy as np
import pytest

from common.geometry import rotation_from_vector, vector_from_rotation
from lab.visual_operator.hand import Motor, ScriptedHand

CALM = Motor(noise_m=0.0, noise_rad=0.0)
TIMES_S = np.arange(0.0, 4.0, 0.002)


def positions(hand):
    return np.array([hand.at(t)[0] for t in TIMES_S])


@pytest.mark.parametrize("far_m", [0.01, 0.1, 0.4])
def test_a_movement_ends_where_it_should_and_is_never_faster_than_the_limit(far_m):
    hand = ScriptedHand(CALM, seed=1)
    end_s = hand.move(0.5, np.array([far_m, 0.0, 0.0]), np.eye(3))
    assert end_s - 0.5 >= CALM.least_s
    offset, turn, openness = hand.at(end_s + 0.01)
    assert offset == pytest.approx([far_m, 0, 0])
    assert not turn.any()
    assert openness == 0.0
    speeds = np.linalg.norm(np.diff(positions(hand), axis=0), axis=1) / 0.002
    assert speeds.max() <= CALM.speed_m_s * 1.001
    assert CALM.speed_m_s <= 0.5


def test_a_turn_is_never_faster_than_the_limit():
    hand = ScriptedHand(CALM, seed=1)
    hand.move(0.0, np.zeros(3), rotation_from_vector(np.array([0.0, 0.0, 0.9])))
    turns = [rotation_from_vector(hand.at(t)[1]) for t in TIMES_S]
    rates = [np.linalg.norm(vector_from_rotation(b @ a.T)) / 0.002 for a, b in itertools.pairwise(turns)]
    assert 0.9 * CALM.turn_rad_s < max(rates) <= CALM.turn_rad_s * 1.001


def test_movements_follow_on_each_other_without_a_jump():
    hand = ScriptedHand(CALM, seed=1)
    hand.move(0.2, np.array([0.1, 0.0, 0.0]), np.eye(3))
    hand.move(2.0, np.array([0.0, 0.1, 0.0]), np.eye(3))
    assert np.linalg.norm(np.diff(positions(hand), axis=0), axis=1).max() < 0.001
    assert hand.aim()[0] == pytest.approx([0.1, 0.1, 0.0])


def test_the_noise_has_the_spread_that_the_motor_names():
    motor = Motor()
    hand = ScriptedHand(motor, seed=3)
    places, turns, *_ = zip(*(hand.at(t) for t in np.arange(5.0, 405.0, 0.25)), strict=True)
    for noise, sigma in ((places, motor.noise_m), (turns, motor.noise_rad)):
        assert np.std(np.array(noise), axis=0) == pytest.approx(3 * [sigma], rel=0.15)


def test_the_same_seed_trembles_alike_and_another_does_not():
    one, same, other = (ScriptedHand(Motor(), seed).at(3.3)[0] for seed in (5, 5, 6))
    assert one == pytest.approx(same)
    assert np.abs(one - other).max() > 1e-5


def test_an_opening_opens_and_closes_the_hand():
    hand = ScriptedHand(CALM, seed=1)
    end_s = hand.open_at(1.0)
    assert [hand.at(t)[2] for t in (0.9, 1.5, end_s + 0.01)] == pytest.approx([0, 1, 0])
    assert (hand.openings_until(0.9), hand.openings_until(1.1)) == (0, 1)
