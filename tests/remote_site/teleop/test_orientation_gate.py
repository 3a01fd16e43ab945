"""The orientation gate: an opening hand and a swapped finger never swing the tool."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.geometry import Array, rotation_from_vector
from remote_site.safety.config import SafetyConfig
from remote_site.teleop.sample_validator import OrientationGate

FRAME_NS = 33 * NS_PER_MS


def turned(degrees: float) -> Array:
    return rotation_from_vector(np.radians([0.0, 0.0, degrees]))


def judged(angles):
    """The gate's answers to one orientation (deg) or None per frame."""
    gate = OrientationGate(SafetyConfig())
    rotations = [None if angle is None else turned(angle) for angle in angles]
    return [gate.judge(rotation, k * FRAME_NS) is not None for k, rotation in enumerate(rotations, start=1)]


def test_a_calm_hand_acts_after_the_settling_time():
    assert judged([0.0] * 10) == [False] * 7 + [True] * 3


@pytest.mark.parametrize("speed_deg_s", [10, 60, 110])
def test_a_turn_as_a_hand_means_it_acts_throughout(speed_deg_s):
    angles = [0.0] * 10 + [k * 0.033 * speed_deg_s for k in range(20)]
    assert all(judged(angles)[7:])


def test_a_sudden_turn_is_withheld_until_it_has_been_calm():
    answers = judged([0.0] * 20 + [25.0] * 10)
    assert answers[19:] == [True] + [False] * 7 + [True] * 3


def test_an_absent_orientation_starts_the_settling_anew():
    answers = judged([0.0] * 20 + [None] * 3 + [0.0] * 10)
    assert answers[20:] == [False] * 10 + [True] * 3
