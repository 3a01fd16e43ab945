"""What disturbs a tracker in the room: seen by both cameras, moving where it should, never changing the arm."""

import typing
from functools import cache

import numpy as np
import pytest

from local_site.simulation.config import MotionConfig, PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import DisturbanceName, RoomConfig

NAMES = typing.get_args(DisturbanceName)
MOVING = {"second_arm", "face", "fan", "shadows"}


SMALL = StereoConfig(width_px=320, height_px=240, focal_px=400.0)


@cache
def operator(*disturbances):
    """Without noise, so that its pictures depend on the times alone."""
    return new_operator(*disturbances)


def new_operator(*disturbances):
    return SimulatedOperator(
        SimulationConfig(
            stereo=SMALL,
            picture=PictureConfig(noise_sigma=0.0),
            motion=MotionConfig(name="hold"),
            room=RoomConfig(scene="office", disturbances=disturbances),
        )
    )


def pictures(*disturbances, filmed_s=0.0):
    return np.stack(operator(*disturbances).render(0.0, (0, 1), filmed_s)).astype(int)


def differing(one, other):
    """How many pixels of each view differ clearly."""
    return np.count_nonzero(np.abs(one - other).max(axis=3) > 12, axis=(1, 2))


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_each_is_seen_in_both_views(name):
    assert differing(pictures(), pictures(name)).min() > 75


@pytest.mark.parametrize("name", NAMES)
def test_what_should_move_moves_though_the_operator_keeps_still(name):
    moved = differing(pictures(name, filmed_s=0.2), pictures(name, filmed_s=1.1))
    assert (moved.max() > 25) == (name in MOVING)


def test_none_changes_the_truth_nor_hides_the_hand():
    alone, among = operator(), operator(*NAMES)
    for name, point in alone.points(0.0).items():
        assert np.array_equal(point, among.points(0.0)[name])
    hand = np.s_[:, 42:75, 117:160]  # of the left view
    same = np.abs(pictures()[hand] - pictures(*NAMES)[hand]).max(axis=3)[0] <= 2
    assert np.count_nonzero(same) > 375


def test_several_are_the_same_for_the_same_seed():
    again = np.stack(new_operator(*NAMES).render(0.0, (0, 1), 1.7)).astype(int)
    assert np.array_equal(pictures(*NAMES, filmed_s=1.7), again)
