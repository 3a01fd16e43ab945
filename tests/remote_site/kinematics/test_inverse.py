"""Inverse kinematics: every branch leads back to the target, and the nearest one keeps the arm's branch."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.errors import ModelError
from common.geometry import rotation_from_vector, transform, vector_from_rotation
from remote_site.kinematics.config import BranchConfig
from remote_site.kinematics.inverse import Solution, SphericalWristInverse, Unreachable
from remote_site.kinematics.limits import TARGET_SPEED
from remote_site.kinematics.model import ArmModel
from remote_site.kinematics.upright_arm import SHOULDER_HOLD, UprightArm
from remote_site.reasons import Code
from tests.present import present
from tests.remote_site.remote_loop import arm

MODEL, LIMITS = arm()
INVERSE = SphericalWristInverse(MODEL, LIMITS)
START = np.radians([0.0, 0.0, -45.0, 0.0, -45.0, 0.0])

postures = st.tuples(*(st.floats(low, high) for low, high in zip(LIMITS.lower, LIMITS.upper, strict=True))).map(
    np.array
)


def off(q, pose):
    return np.abs(MODEL.forward(q) - pose).max()


@settings(max_examples=300, deadline=None, derandomize=True)
@given(postures)
def test_all_eight_branches_lead_back_to_the_pose(q):
    pose = MODEL.forward(q)
    solutions = INVERSE.solutions(pose)
    assert len(solutions) == 8
    assert len({solution.branch for solution in solutions}) >= 4
    for solution in solutions:
        assert off(solution.q, pose) < 1e-9


@pytest.mark.parametrize("pitch", [-0.8, 0.8])
def test_every_solution_states_the_branch_of_its_posture(pitch):
    branch_of = UprightArm.from_model(MODEL).branch_of
    q = np.array([0.4, -0.3, -1.2, 0.5, pitch, 0.2])
    solutions = INVERSE.solutions(MODEL.forward(q))
    assert [solution.branch for solution in solutions] == [branch_of(tuple(solution.q)) for solution in solutions]
    assert len({solution.branch for solution in solutions}) == 8
    result = INVERSE.nearest(MODEL.forward(q), q)
    assert isinstance(result, Solution)
    assert result.branch == branch_of(tuple(q))


class Crooked(ArmModel):
    """An arm that fits the closed form at its zero posture, and is 10 mm off it where its test says."""

    pin_model, joint_names = MODEL.pin_model, MODEL.joint_names

    def __init__(self, is_off):
        self._is_off = is_off

    def forward(self, q):
        pose = MODEL.forward(q).copy()
        pose[0, 3] += 0.01 * self._is_off((q - LIMITS.lower) / (LIMITS.upper - LIMITS.lower))
        return pose


@pytest.mark.parametrize(("high", "low"), list(permutations(range(6), 2)))
def test_an_arm_that_the_closed_form_does_not_fit_in_a_quarter_of_its_range_is_refused(high, low):
    def is_off(part):
        return part[high] > 0.5 > part[low]

    with pytest.raises(ModelError, match="does not lead back"):
        SphericalWristInverse(Crooked(is_off), LIMITS).verify()


def test_a_stretched_elbow_counts_as_bent_forward():
    SphericalWristInverse(MODEL, LIMITS, BranchConfig(elbow="forward")).check_branch(np.zeros(6))
    with pytest.raises(ModelError, match="elbow"):
        SphericalWristInverse(MODEL, LIMITS, BranchConfig(elbow="backward")).check_branch(np.zeros(6))


def lost(q, pose):
    """The angle by which the tool is not turned as it should be, rad."""
    return np.linalg.norm(vector_from_rotation(MODEL.forward(q)[:3, :3].T @ pose[:3, :3]))


@settings(max_examples=300, deadline=None, derandomize=True)
@given(postures)
def test_the_nearest_solution_to_where_the_arm_is_is_where_it_is(q):
    result = INVERSE.nearest(MODEL.forward(q), q)
    assert isinstance(result, Solution)
    if result.held or result.lost_rad:
        return
    assert off(result.q, MODEL.forward(q)) < 1e-9
    # at the elbow's stretch two solutions meet, a square root apart from rounding
    assert np.abs(result.q[:3] - q[:3]).max() < 1e-6
    # nearly straight, the wrist may take the goal of joint 4 nearer to its middle
    assert np.abs(result.q - q).max() < 1e-6 or abs(q[4]) < 0.36


@settings(max_examples=150, deadline=None, derandomize=True)
@given(postures, st.lists(st.floats(-0.02, 0.02), min_size=6, max_size=6))
def test_a_solution_near_the_arm_is_within_limits_and_keeps_the_tools_position(q, step):
    pose = MODEL.forward(q)
    result = INVERSE.nearest(pose, q + np.array(step))
    if not isinstance(result, Solution):
        assert result.reason.code in (Code.IK_LIMIT, Code.OUT_OF_REACH, Code.STANCE)
        return
    assert (result.q >= LIMITS.lower - 1e-9).all()
    assert (result.q <= LIMITS.upper + 1e-9).all()
    assert np.abs(MODEL.forward(result.q)[:3, 3] - pose[:3, 3]).max() < (SHOULDER_HOLD if result.held else 1e-6)
    assert lost(result.q, pose) == pytest.approx(result.lost_rad, abs=1e-3) or result.held


def test_a_straight_wrist_does_not_spin_joint_4_and_keeps_the_position():
    rng = np.random.default_rng(3)
    q = START + np.array([0.0, 0.0, 0.0, 0.3, 0.8, -0.2])
    q[4] = 0.0
    pose = MODEL.forward(q)
    for _ in range(100):
        noisy = transform(rotation_from_vector(rng.normal(0, 0.01, 3)) @ pose[:3, :3], pose[:3, 3])
        result = INVERSE.nearest(noisy, q)
        assert isinstance(result, Solution)
        assert np.abs(MODEL.forward(result.q)[:3, 3] - pose[:3, 3]).max() < 1e-6
        assert lost(result.q, noisy) < 0.05
        assert abs(result.q[3] - q[3]) < 0.05
        q = result.q
    assert abs(q[3] - 0.3) < 0.3


@pytest.mark.parametrize(("bend", "rate"), [(1.0, 60.0), (0.5, 15.0), (0.25, 3.75)])
def test_joint_4_goes_the_slower_to_its_goal_the_straighter_the_wrist_is(bend, rate):
    """With the square of the bend: half as bent, a quarter as fast."""
    q = START.copy()
    q[4] = np.arcsin(0.999 * bend * 0.35)
    wanted = q + np.array([0.0, 0.0, 0.0, 0.02, 0.0, 0.0])
    result = INVERSE.nearest(MODEL.forward(wanted), q, elapsed_s=0.02)
    assert isinstance(result, Solution)
    assert result.q[3] / 0.02 == pytest.approx(1.0 - np.exp(-0.02 * rate), rel=0.01)


def test_joint_4_goes_no_faster_than_it_can_and_arrives():
    q = START.copy()
    wanted = q + np.array([0.0, 0.0, 0.0, 0.9, 0.0, 0.0])
    pose = MODEL.forward(wanted)
    for _ in range(24):
        result = INVERSE.nearest(pose, q, elapsed_s=0.02)
        assert isinstance(result, Solution)
        assert abs(result.q[3] - q[3]) <= TARGET_SPEED * LIMITS.velocity[3] * 0.02 + 1e-9
        assert np.abs(MODEL.forward(result.q)[:3, 3] - pose[:3, 3]).max() < 1e-6
        q = result.q
    assert q == pytest.approx(wanted, abs=1e-9)


def test_joint_4_at_its_limit_loses_orientation_but_not_position_until_its_other_place_is_near():
    q = START.copy()
    q[3], q[4] = LIMITS.upper[3] - 0.01, -0.6
    for turn in np.linspace(0, 2.0, 60):
        wanted = START.copy()
        wanted[3], wanted[4] = LIMITS.upper[3] - 0.01 + turn, -0.6
        pose = MODEL.forward(wanted)
        result = INVERSE.nearest(pose, q)
        assert isinstance(result, Solution)
        assert result.q[3] <= LIMITS.upper[3]
        assert lost(result.q, pose) <= 0.8
        assert np.abs(MODEL.forward(result.q)[:3, 3] - pose[:3, 3]).max() < 1e-6
        q = result.q
    assert q[3] < LIMITS.upper[3] - 0.5  # the other goal of joint 4 came near


def test_a_smooth_path_of_the_tool_is_a_smooth_path_of_the_joints():
    posture = np.array([0.0, 0.2, -1.4, 0.1, -1.1, 0.0])
    start, q = MODEL.forward(posture), posture
    for t in np.linspace(0, 2 * np.pi, 800):
        turn = rotation_from_vector(0.2 * np.array([np.sin(t), np.sin(2 * t), np.sin(3 * t)]))
        shift = 0.04 * np.array([np.sin(2 * t), np.sin(t), np.sin(3 * t)])
        pose = transform(turn @ start[:3, :3], start[:3, 3] + shift)
        result = INVERSE.nearest(pose, q)
        assert isinstance(result, Solution)
        assert off(result.q, pose) < 1e-9
        assert np.abs(result.q - q).max() < 0.05
        q = result.q
    assert q == pytest.approx(posture, abs=1e-9)


def test_the_wrist_passes_straight_through_its_singularity():
    q = START.copy()
    for pitch in np.linspace(-0.503, 0.503, 101):
        wanted = START.copy()
        wanted[4] = pitch
        result = INVERSE.nearest(MODEL.forward(wanted), q)
        assert isinstance(result, Solution)
        assert np.abs(result.q - wanted).max() < 1e-9
        q = result.q


def test_above_the_shoulder_joint_1_is_held_and_little_position_lost():
    q = np.array([0.7, -0.3, 0.0, 0.4, 0.9, 0.1])
    q[2] = 2 * np.arctan2(np.sin(0.3), 1.0)
    near = None
    for bend in np.linspace(0.3, 1.2, 20001):
        q[2] = bend
        r = -0.3048 * np.sin(q[1]) - 0.3302 * np.sin(q[1] + bend)
        if near is None or abs(r) < near[0]:
            near = abs(r), bend
    q[2] = present(near)[1]
    assert present(near)[0] < 1e-4
    pose = MODEL.forward(q)
    pose[:2, 3] += [3e-4, -3e-4]
    result = INVERSE.nearest(pose, q)
    assert isinstance(result, Solution)
    assert result.held
    assert result.q[0] == pytest.approx(0.7)
    assert np.linalg.norm((MODEL.forward(result.q) - pose)[:3, 3]) < SHOULDER_HOLD


def test_joint_6_goes_on_turning_instead_of_jumping_back():
    q = START.copy()
    q[5] = 3.0
    wanted = q.copy()
    wanted[5] = 3.1
    result = INVERSE.nearest(MODEL.forward(wanted), q)
    assert isinstance(result, Solution)
    assert result.q[5] == pytest.approx(3.1)


def test_joint_6_stops_at_its_limit_and_is_not_taken_the_other_way_round():
    q = START.copy()
    q[5] = LIMITS.upper[5] - 0.01
    pose = MODEL.forward(q)
    for turn, reachable in ((0.05, True), (0.6, True), (1.0, False)):
        spun = pose @ transform(rotation_from_vector(np.array([0.0, 0.0, turn])), np.zeros(3))
        result = INVERSE.nearest(spun, q)
        assert isinstance(result, Solution) == reachable
        if isinstance(result, Solution):
            assert result.q[5] == pytest.approx(LIMITS.upper[5])
            assert result.lost_rad == pytest.approx(turn - 0.01)
        else:
            assert result.reason.code is Code.IK_LIMIT


@pytest.mark.parametrize(
    ("shift", "words"), [((3.0, 0.0, 0.0), "out of reach"), ((-0.444, 0.0, -0.5), "out of reach"), ((0, 0, -1.2), "")]
)
def test_an_unreachable_target_is_answered_with_the_reason(shift, words):
    pose = MODEL.forward(START)
    pose[:3, 3] += shift
    result = INVERSE.nearest(pose, START)
    assert isinstance(result, Unreachable)
    assert words in result.reason.sentence


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", [(0, 3), (2, 3), (0, 0), (2, 1)])
def test_a_target_that_is_not_finite_is_refused(value, place):
    pose = MODEL.forward(START)
    pose[place] = value
    with np.errstate(invalid="ignore"):
        result = INVERSE.nearest(pose, START)
        assert INVERSE.solutions(pose) == []
    assert isinstance(result, Unreachable)
    assert result.reason.code is Code.NOT_A_POSE


def test_a_posture_or_rotation_that_is_none_is_refused():
    pose = MODEL.forward(START)
    assert isinstance(INVERSE.nearest(pose, START * np.nan), Unreachable)
    mirrored = pose.copy()
    mirrored[:3, 0] *= -1
    assert isinstance(INVERSE.nearest(mirrored, START), Unreachable)
    stretched = pose.copy()
    stretched[:3, :3] *= 1.1
    assert isinstance(INVERSE.nearest(stretched, START), Unreachable)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.lists(st.floats(-2, 2), min_size=6, max_size=6))
def test_any_target_gets_an_answer_without_nan(values):
    pose = transform(rotation_from_vector(np.array(values[:3])), np.array(values[3:]))
    result = INVERSE.nearest(pose, START)
    if isinstance(result, Solution):
        assert np.isfinite(result.q).all()
        assert (result.q >= LIMITS.lower - 1e-9).all()
        assert (result.q <= LIMITS.upper + 1e-9).all()
        assert np.abs(result.q - START).max() <= 1.0 or result.branch == (1, 1, 1)
        if not result.held:
            assert np.abs(MODEL.forward(result.q)[:3, 3] - pose[:3, 3]).max() < 1e-5
