"""The guard: each of its rules, one by one, and what no sequence of proposals gets past it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remote_site.config import RemoteConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code
from remote_site.safety.clearance import Workspace
from remote_site.safety.config import CollisionConfig, SafetyConfig
from remote_site.safety.guard import JointGuard, Passed, Refused
from remote_site.safety.stopping import stop_time, stops
from tests.remote_site.remote_loop import arm, clearance, guard_of, workspace

DT = 0.004
MODEL, LIMITS = arm()
START = np.radians([0.0, 0.0, -45.0, 0.0, -45.0, 0.0])


@pytest.fixture
def guard():
    return guard_of()


def moving(q=START, joint=0, velocity=0.0, acceleration=0.0):
    motion = JointMotion.at_rest(q)
    motion.dq[joint], motion.ddq[joint] = velocity, acceleration
    return motion


def after(motion, jerk=0.0, joint=0, dt=DT):
    """One tick of constant jerk of one joint."""
    jerks = np.zeros(6)
    jerks[joint] = jerk
    return JointMotion(
        motion.q + dt * motion.dq + dt**2 / 2 * motion.ddq + dt**3 / 6 * jerks,
        motion.dq + dt * motion.ddq + dt**2 / 2 * jerks,
        motion.ddq + dt * jerks,
    )


def a_wall():
    """A workspace that ends right beside the tool, to the left."""
    return Workspace(workspace().lower, np.array([0.80, 0.01, 1.25]))


def code(verdict):
    return verdict.reason.code if isinstance(verdict, Refused) else Code.OK


def test_rest_and_motion_within_limits_pass(guard):
    rest = moving()
    assert isinstance(guard.check(rest, rest), Passed)
    assert isinstance(guard.check(after(rest, 900.0), rest), Passed)
    coasting = moving(velocity=1.0)
    assert isinstance(guard.check(after(coasting), coasting), Passed)


@pytest.mark.parametrize("field", ["q", "dq", "ddq"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("joint", range(6))
def test_nothing_that_is_not_finite_passes(guard, field, value, joint):
    broken = replace(moving(), **{field: np.where(np.arange(6) == joint, value, 0.0)})
    assert code(guard.check(broken, moving())) is Code.NOT_FINITE
    assert code(guard.check(moving(), broken)) is Code.NOT_FINITE
    joints = JointGuard(LIMITS, DT)
    assert code(joints.check(broken, moving())) is Code.NOT_FINITE
    assert code(joints.check(moving(), broken)) is Code.NOT_FINITE


@pytest.mark.parametrize(("field", "off"), [("q", 1e-9), ("dq", 1e-9 / DT), ("ddq", 1e-9 / DT**2)])
def test_motions_are_the_same_up_to_rounding(field, off):
    rest, joints = moving(), JointGuard(LIMITS, DT)
    assert joints.same(replace(rest, **{field: getattr(rest, field) + 0.9 * off}), rest)
    assert not joints.same(replace(rest, **{field: getattr(rest, field) + 1.1 * off}), rest)


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("side", [1, -1])
def test_too_fast_is_refused(guard, joint, side):
    fast = moving(velocity=side * LIMITS.velocity[joint] * 1.001, joint=joint)
    assert code(guard.check(after(fast), fast)) is Code.VELOCITY


def test_a_velocity_that_cannot_be_kept_from_the_limit_is_refused(guard):
    rising = moving(velocity=LIMITS.velocity[0] - 0.01, acceleration=9.0)
    assert code(guard.check(after(rising, -1000.0), rising)) is Code.VELOCITY


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("side", [1, -1])
def test_too_much_acceleration_is_refused(guard, joint, side):
    before = moving(acceleration=side * (LIMITS.acceleration[joint] - 0.1), joint=joint)
    assert code(guard.check(after(before, side * 100.0, joint), before)) is Code.ACCELERATION


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("side", [1, -1])
def test_too_much_jerk_is_refused(guard, joint, side):
    assert code(guard.check(after(moving(), side * 1001.0, joint), moving())) is Code.JERK


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize(("dq", "q"), [(0.005, 0.0), (-0.005, 0.0), (0.0, 1e-5), (0.0, -1e-5)])
def test_position_and_velocity_must_follow_from_the_last_command(guard, joint, dq, q):
    jumped = moving(velocity=dq, joint=joint)
    jumped.q[joint] += q
    assert code(guard.check(jumped, moving())) is Code.INCONSISTENT


@pytest.mark.parametrize("joint", range(6))
def test_velocity_must_follow_from_the_acceleration_even_if_the_position_fits(guard, joint):
    fitting = moving(velocity=0.01, joint=joint)
    fitting.q[joint] += DT / 2 * 0.01
    assert code(guard.check(fitting, moving())) is Code.INCONSISTENT


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_that_could_not_stop_before_its_limit_is_refused(joint, side):
    guard = JointGuard(LIMITS, DT)
    end = LIMITS.upper[joint] if side > 0 else LIMITS.lower[joint]
    q = START.copy()
    most = LIMITS.acceleration[joint]
    room = 1.0 / (2 * most) + most / (2 * LIMITS.jerk[joint])  # what stopping from 1 rad/s takes
    q[joint] = end - side * (room + 0.003)
    near = moving(q=q, velocity=side, joint=joint)
    assert isinstance(guard.check(after(near), near), Refused)
    q[joint] = end - side * (room + 0.005)
    far = moving(q=q, velocity=side, joint=joint)
    assert isinstance(guard.check(after(far), far), Passed)


def test_an_arm_outside_its_limits_may_only_retreat(guard):
    q = START.copy()
    q[5] = LIMITS.upper[5] + 0.1
    outside = moving(q=q)
    assert code(guard.check(after(outside, 100.0, 5), outside)) is Code.POSITION
    assert isinstance(guard.check(after(outside, -100.0, 5), outside), Passed)
    assert isinstance(guard.check(outside, outside), Passed)


def test_a_tool_outside_the_workspace_may_only_retreat():
    below = Workspace(np.array([0.15, -0.55, 0.25]), np.array([0.80, 0.55, 0.80]))
    guard = guard_of(box=below)
    outside = moving()
    up, down = (1, 300.0), (1, -300.0)  # joint 2 leans back with positive jerk, which lifts the tool
    assert code(guard.check(after(outside, up[1], up[0]), outside)) is Code.WORKSPACE
    assert isinstance(guard.check(after(outside, down[1], down[0]), outside), Passed)


def test_a_tool_that_could_not_stop_inside_the_workspace_is_refused():
    guard = guard_of(box=a_wall())
    left = moving(velocity=0.6)
    assert code(guard.check(after(left), left)) is Code.WORKSPACE
    assert isinstance(guard.check(guard.stop(left), left), Passed)


motions = st.tuples(
    st.lists(st.floats(-1.7, 1.7), min_size=6, max_size=6),
    st.lists(st.floats(-2.9, 2.9), min_size=6, max_size=6),
    st.lists(st.floats(-10, 10), min_size=6, max_size=6),
)


@pytest.mark.slow
@settings(max_examples=60, deadline=None, derandomize=True)
@given(motions)
def test_the_stop_always_passes_and_ends_in_time(values):
    guard = guard_of()
    motion = JointMotion(*(np.array(v) for v in values))
    coasting = motion.dq + motion.ddq * np.abs(motion.ddq) / 2000
    if (np.abs(coasting) > LIMITS.velocity).any():
        return
    ticks = int(stop_time(motion, LIMITS) / DT) + 2
    for _ in range(ticks):
        stop = guard.stop(motion)
        verdict = guard.check(stop, motion)
        assert isinstance(verdict, Passed), verdict
        motion = stop
    assert motion.resting


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.lists(st.tuples(st.lists(st.floats(-1400, 1400), min_size=6, max_size=6), st.integers(1, 15)), max_size=15))
def test_whatever_jerks_are_proposed_the_sent_motion_stays_within_every_limit(sequence):
    guard = guard_of()
    sent = JointMotion.at_rest(START)
    for jerks, ticks in sequence:
        for _ in range(ticks):
            jerk = np.array(jerks)
            proposed = JointMotion(
                sent.q + DT * sent.dq + DT**2 / 2 * sent.ddq + DT**3 / 6 * jerk,
                sent.dq + DT * sent.ddq + DT**2 / 2 * jerk,
                sent.ddq + DT * jerk,
            )
            previous, passed = sent, isinstance(guard.check(proposed, sent), Passed)
            sent = proposed if passed else guard.stop(sent)
            assert isinstance(guard.check(sent, previous), Passed)
            assert (np.abs(sent.dq) <= LIMITS.velocity * 1.00001).all()
            assert (np.abs(sent.ddq) <= LIMITS.acceleration * 1.00001).all()
            assert (np.abs(sent.ddq - previous.ddq) <= LIMITS.jerk * DT * 1.00001).all()
            assert (sent.q >= LIMITS.lower - 1e-6).all()
            assert (sent.q <= LIMITS.upper + 1e-6).all()
            assert workspace().excess(MODEL.forward(sent.q)[:3, 3]) < 0.001


jerks = st.lists(st.floats(-1400, 1400), min_size=6, max_size=6)
broken = st.sampled_from([np.nan, np.inf, 1e6])


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.lists(st.tuples(jerks, st.integers(1, 12), st.none() | broken), max_size=12))
def test_whatever_is_proposed_the_driver_receives_what_can_stop_where_it_may_be(sequence):
    """The invariant on every command: finite, limits kept, and its jerk-limited stop inside joints, box and margins."""
    guard, around, sent = guard_of(), clearance(), JointMotion.at_rest(START)
    margin = around.collision.margin
    for values, ticks, spoilt in sequence:
        for _ in range(ticks):
            jerk = np.array(values)
            proposed = after(sent)
            ddq = sent.ddq + DT * jerk
            q, dq = proposed.q + DT**3 / 6 * jerk, proposed.dq + DT**2 / 2 * jerk
            if spoilt is not None:
                q[0] = spoilt
            proposed = JointMotion(q, dq, ddq)
            previous = sent
            sent = proposed if isinstance(guard.check(proposed, sent), Passed) else guard.stop(sent)
            assert sent.finite
            assert (np.abs(sent.dq) <= LIMITS.velocity * 1.00001).all()
            assert (np.abs(sent.ddq) <= LIMITS.acceleration * 1.00001).all()
            assert (np.abs(sent.ddq - previous.ddq) <= LIMITS.jerk * DT * 1.00001).all()
    ends = stops(sent, LIMITS)
    for t in np.linspace(0.0, max(end.duration for end in ends), 25):
        q = np.array([end.at(t)[0] for end in ends])
        assert (q >= LIMITS.lower - 1e-6).all()
        assert (q <= LIMITS.upper + 1e-6).all()
        assert workspace().excess(MODEL.forward(q)[:3, 3]) < 0.001
        assert around.collision.distance(q) >= margin


def test_a_stop_that_is_replaced_by_another_motion_is_refused():
    """Only the stop from what was sent is let through without looking at the surroundings."""
    guard, left = guard_of(box=a_wall()), moving(velocity=0.8)
    stop = guard.stop(left)
    assert isinstance(guard.check(stop, left), Passed)
    other = replace(stop, ddq=stop.ddq + 0.5)
    verdict = guard.check(other, left)
    assert isinstance(verdict, Refused)
    assert verdict.reason.code in (Code.WORKSPACE, Code.INCONSISTENT)


def test_a_refusal_of_the_clearance_names_its_figures():
    depth = MODEL.forward(START)[0, 3]
    beyond = Workspace(np.array([depth + 0.515, -2.0, -2.0]), np.array([3.0, 2.0, 3.0]))
    why = clearance(box=beyond).why(moving(), stops(moving(), LIMITS))
    assert "515.0 mm outside" in why.sentence
    low = START + np.radians([0, -70, 0, 0, 0, 0])
    down = moving(q=low)
    wide = RemoteConfig(safety=SafetyConfig(collision=CollisionConfig(margin_m=0.19, slow_m=0.2)))
    check = clearance(wide, Workspace(np.full(3, -3.0), np.full(3, 3.0)))
    why = check.why(down, stops(down, LIMITS))
    assert f"within {check.collision.distance(low) * 1e3:.1f} mm" in why.sentence
    assert "(limit 190.0 mm)" in why.sentence
