"""The simulated operator's motions: smooth, repeatable, and as described."""

import itertools
import typing

import numpy as np
import pytest

from common.errors import ConfigError
from common.geometry import vector_from_rotation
from local_site.simulation.body import ArmBody
from local_site.simulation.config import BodyConfig, MotionConfig, MotionName
from local_site.simulation.motion import HandPath, Motion, minimum_jerk

NAMES = typing.get_args(MotionName)


def motion(name, **settings):
    return Motion(MotionConfig(name=name, **settings), BodyConfig(), seed=1)


@pytest.mark.parametrize("name", NAMES)
def test_every_motion_begins_with_stillness_in_one_bent_posture(name):
    first, last = motion(name).pose(0.0), motion(name).pose(2.0)
    assert last.wrist == pytest.approx(first.wrist)
    assert last.operator_R_hand == pytest.approx(first.operator_R_hand)
    assert first.openness == last.openness == 0.0
    upper, fore = first.shoulder - first.elbow, first.wrist - first.elbow
    bend = np.degrees(np.arccos(upper @ fore / np.linalg.norm(upper) / np.linalg.norm(fore)))
    assert 100 < bend < 132
    assert first.wrist[2] > first.shoulder[2]


@pytest.mark.parametrize("name", NAMES)
def test_motions_are_smooth(name):
    step_s = 5e-3
    path = motion(name)
    wrists = np.array([path.pose(t).wrist for t in np.arange(1.9, 17.0, step_s)])
    speed = np.linalg.norm(np.diff(wrists, axis=0), axis=1) / step_s
    acceleration = np.linalg.norm(np.diff(wrists, 2, axis=0), axis=1) / step_s**2
    assert speed.max() < 0.26
    assert acceleration.max() < 1.0
    # Continuous acceleration: it changes by little from one instant to the next.
    assert np.abs(np.diff(acceleration)).max() < 0.02


@pytest.mark.parametrize("name", NAMES)
def test_hands_turn_without_jumps(name):
    path = motion(name)
    rotations = [path.pose(t).operator_R_hand for t in np.arange(1.9, 8.0, 0.01)]
    turns = [np.linalg.norm(vector_from_rotation(a.T @ b)) for a, b in itertools.pairwise(rotations)]
    assert max(turns) < 0.12


@pytest.mark.parametrize(("name", "axis"), [("rotate_x", 0), ("rotate_y", 1), ("rotate_z", 2)])
def test_rotations_turn_about_their_axis_with_the_wrist_still(name, axis):
    path = motion(name)
    start = path.pose(0.0)
    turned = [path.pose(t) for t in np.linspace(4.0, 9.0, 40)]
    vectors = np.array([vector_from_rotation(pose.operator_R_hand @ start.operator_R_hand.T) for pose in turned])
    assert np.degrees(np.abs(vectors[:, axis]).max()) == pytest.approx(25.0, abs=0.5)
    assert np.delete(vectors, axis, axis=1) == pytest.approx(0.0, abs=1e-9)
    assert all(pose.wrist == pytest.approx(start.wrist) for pose in turned)


def test_pick_and_place_goes_where_it_should_and_returns():
    path = motion("pick_and_place")
    start = path.pose(0.0).wrist
    assert path.pose(2.0 + 3.6).wrist - start == pytest.approx([0.0, -0.08, -0.16])
    assert path.pose(2.0 + 6.0).wrist - start == pytest.approx([0.0, -0.08, -0.12])
    assert path.pose(2.0 + 9.5).wrist - start == pytest.approx([-0.20, -0.08, -0.13])
    assert path.pose(2.0 + 13.0).wrist == pytest.approx(start)
    assert path.pose(2.0 + 13.0 + 4.0).wrist - start == pytest.approx([-0.20, -0.08, -0.16])
    assert path.pose(2.0 + 13.0 + 9.5).wrist - start == pytest.approx([0.0, -0.08, -0.13])
    assert path.pose(2.0 + 26.0 + 3.6).wrist - start == pytest.approx([0.0, -0.08, -0.16])


@pytest.mark.parametrize("name", NAMES)
def test_every_motion_stays_within_the_arms_reach(name):
    path, body = motion(name), ArmBody(BodyConfig())
    for t in np.arange(0.0, 40.0, 0.5):
        assert np.isfinite(body.truth(path.pose(t)).elbow).all()


@pytest.mark.parametrize("name", ["pick_and_place", "toggles"])
def test_openings_are_counted_and_the_wrist_is_still_meanwhile(name):
    path, body = motion(name), ArmBody(BodyConfig())
    times = np.arange(0.0, 22.0, 0.02)
    poses = [path.pose(t) for t in times]
    opened = np.array([body.truth(pose).hand_open for pose in poses])
    rises = times[1:][np.diff(opened.astype(int)) == 1]
    assert path.openings_until(-1.0) == 0
    assert path.openings_until(22.0) == len(rises) >= 3
    for k, rise in enumerate(rises):
        assert path.openings_until(rise - 0.15) == k
        assert path.openings_until(rise) == k + 1
    still = [k for k, pose in enumerate(poses) if pose.openness > 0]
    assert all(path.pose(times[k] + 0.02).wrist == pytest.approx(poses[k].wrist, abs=1e-9) for k in still)


def test_openings_last_half_a_second():
    path = motion("toggles")
    openness = np.array([path.pose(t).openness for t in np.arange(2.0, 4.0, 0.005)])
    assert np.count_nonzero(openness > 0.999) == pytest.approx(100, abs=10)


def test_tremor_is_seeded_and_small():
    def wrist(seed, tremor_mm=1.0):
        return Motion(MotionConfig(name="hold", tremor_mm=tremor_mm), BodyConfig(), seed).pose(1.234).wrist

    assert wrist(1) == pytest.approx(wrist(1), abs=0)
    assert np.abs(wrist(1) - wrist(2)).max() > 1e-5
    assert np.abs(wrist(1) - wrist(1, tremor_mm=0.0)).max() <= 1e-3


def test_an_arm_too_short_for_the_motion_is_refused():
    with pytest.raises(ConfigError, match="cannot reach"):
        Motion(MotionConfig(), BodyConfig(forearm_length=0.2), seed=1)


def test_a_wrist_straight_below_the_shoulder_is_refused():
    below = MotionConfig(name="hold", shoulder=(0.4, 0.4, 1.0), wrist=(0.4, 0.4, 0.5))
    with pytest.raises(ConfigError, match="straight above or below"):
        Motion(below, BodyConfig(), seed=1)


def test_minimum_jerk_starts_and_ends_at_rest():
    shares = np.array([minimum_jerk(s) for s in np.linspace(-0.5, 1.5, 2001)])
    assert shares[0] == 0.0
    assert shares[-1] == 1.0
    assert np.diff(shares).max() * 1000 == pytest.approx(1.875, abs=1e-3)
    assert np.all(np.diff(shares) >= 0)


def test_a_path_that_is_given_is_followed_and_checked_only_where_it_is_asked_for():
    path = HandPath(lambda t_s: (np.array([-0.05 * t_s, 0.0, 0.0]), np.array([0.0, 0.0, 0.1 * t_s])))
    given = Motion(MotionConfig(name="hold", still_s=1.0), BodyConfig(), seed=1, path=path)
    still, moved = given.pose(0.5), given.pose(2.0)
    assert moved.wrist - still.wrist == pytest.approx([-0.05, 0.0, 0.0])
    turn = vector_from_rotation(moved.operator_R_hand @ still.operator_R_hand.T)
    assert turn == pytest.approx([0.0, 0.0, 0.1])
    assert given.openings_until(9.0) == 0
    with pytest.raises(ConfigError, match="cannot reach"):
        given.pose(9.0)
