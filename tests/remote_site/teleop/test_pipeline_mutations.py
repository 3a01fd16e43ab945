"""Every check between the wire and the driver is needed: with any one taken away, the test named beside it fails."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.clock import NS_PER_MS
from common.messages.robot import SessionState
from remote_site.config import RemoteConfig
from remote_site.kinematics import limits as limits_module
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code
from remote_site.safety.clearance import ClearanceCheck
from remote_site.safety.collision import ClearanceCache, CollisionModel
from remote_site.safety.config import CollisionConfig, FixtureConfig, SafetyConfig
from remote_site.safety.guard import Guard, JointGuard, Passed
from remote_site.safety.stopping import stops
from remote_site.session.hand_signal import HandSignal
from remote_site.session.state_machine import Session
from remote_site.teleop.sample_validator import SampleValidator
from tests.remote_site.mutation import Mutation
from tests.remote_site.remote_loop import (
    RemoteLoop,
    arm,
    clearance,
    guard_of,
    hand,
    workspace,
)
from tests.remote_site.safety import test_collision, test_guard

MODEL, LIMITS = arm()
START = RemoteConfig().robot.start
DT = 0.004
NAN = float("nan")


def a_wall():
    """Surroundings whose tool box ends right beside the tool, to the left."""
    box = workspace()
    return type(box)(box.lower, np.array([0.80, 0.01, 1.25]))


def a_post(thickness=0.01):
    """Obstacles with a thin post between two clear positions."""
    post = FixtureConfig(name="post", min_m=(0.4, 0.10, 0.0), max_m=(0.5, 0.10 + thickness, 1.2))
    collision = CollisionConfig(margin_m=0.005, slow_m=0.02, fixtures=(post,))
    return RemoteConfig(safety=SafetyConfig(collision=collision))


def coasting(velocity, joint=0):
    return test_guard.moving(velocity=velocity, joint=joint)


def nan_never_passes():
    guard = guard_of()
    for field in ("q", "dq", "ddq"):
        test_guard.test_nothing_that_is_not_finite_passes(guard, field, NAN, 0)


def no_velocity_is_due_beyond_its_limit():
    """Slow enough now, but the acceleration cannot be taken back in time."""
    rising = test_guard.moving(velocity=LIMITS.velocity[0] - 0.042, acceleration=9.0)
    assert test_guard.code(guard_of().check(test_guard.after(rising), rising)) is Code.VELOCITY


def no_joint_runs_into_its_limit():
    test_guard.test_a_joint_that_could_not_stop_before_its_limit_is_refused(0, 1)


def no_tool_leaves_its_box():
    guard, left = guard_of(box=a_wall()), coasting(0.6)
    assert not isinstance(guard.check(test_guard.after(left), left), Passed)


def nothing_is_hit_on_the_way_to_rest():
    guard, fast = guard_of(a_post()), coasting(3.0)
    assert not isinstance(guard.check(test_guard.after(fast), fast), Passed)


def nothing_is_hit_at_rest():
    guard, slow = guard_of(a_post(thickness=0.4)), coasting(1.2)
    assert not isinstance(guard.check(test_guard.after(slow), slow), Passed)


def an_arm_too_near_does_not_come_nearer():
    """The gripper is 0.28 m above the table, which wants 0.3 m; joint 2 forward lowers it."""
    table = FixtureConfig(name="table", min_m=(0.3, -1.0, 0.0), max_m=(1.0, 1.0, 0.558))
    collision = CollisionConfig(margin_m=0.19, slow_m=0.2, fixtures=(replace_top(table, 0.7),))
    guard = guard_of(RemoteConfig(safety=SafetyConfig(collision=collision)))
    rest = JointMotion.at_rest(START)
    assert not isinstance(guard.check(test_guard.after(rest, -300.0, 1), rest), Passed)
    assert isinstance(guard.check(test_guard.after(rest, 300.0, 1), rest), Passed)


def replace_top(fixture, top):
    return FixtureConfig(name=fixture.name, min_m=fixture.min_m, max_m=(*fixture.max_m[:2], top))


def broken_joints_are_near_everything():
    test_collision.test_joints_that_are_not_finite_are_never_far_from_anything(NAN, 0)


def nothing_comes_near_unseen():
    test_collision.test_what_an_earlier_measurement_leaves_is_never_more_than_the_distance()


def what_was_noted_elsewhere_does_not_count():
    test_collision.test_a_clearance_is_used_up_by_the_travel_from_where_it_was_noted()


def no_room_covers_nothing():
    test_collision.test_what_has_no_clearance_or_is_not_finite_is_never_covered(-0.01)


def configuration_never_widens():
    from tests.remote_site.kinematics.test_arm_model import test_an_attempt_to_widen_names_every_joint_and_value as body

    body()


MUTATIONS = [
    (Mutation(Guard, "check", "if not (proposed.finite and sent.finite):", "if False:"), nan_never_passes),
    (
        Mutation(JointGuard, "_dynamics", "speed = max(abs(v), abs(v + a * abs(a) / (2 * jerk)))", "speed = 0.0"),
        lambda: test_guard.test_too_fast_is_refused(guard_of(), 0, 1),
    ),
    (
        Mutation(JointGuard, "_dynamics", "max(abs(v), abs(v + a * abs(a) / (2 * jerk)))", "abs(v)"),
        no_velocity_is_due_beyond_its_limit,
    ),
    (
        Mutation(JointGuard, "_dynamics", "if not -acceleration <= a <= acceleration:", "if False:"),
        lambda: test_guard.test_too_much_acceleration_is_refused(guard_of(), 0, 1),
    ),
    (
        Mutation(JointGuard, "_dynamics", "if not -step <= a - a0 <= step:", "if False:"),
        lambda: test_guard.test_too_much_jerk_is_refused(guard_of(), 0, 1),
    ),
    (
        Mutation(JointGuard, "_dynamics", "abs(v - v0 - half * (a + a0)) > velocity_off + POSITION", "False"),
        lambda: test_guard.test_velocity_must_follow_from_the_acceleration_even_if_the_position_fits(guard_of(), 0),
    ),
    (
        Mutation(JointGuard, "_dynamics", "abs(q - q0 - half * (v + v0)) > position_off + POSITION", "False"),
        lambda: test_guard.test_position_and_velocity_must_follow_from_the_last_command(guard_of(), 0, 0.0, 1e-5),
    ),
    (
        Mutation(CollisionModel, "clearances", "if not math.isfinite(sum(q.tolist())):", "if False:"),
        broken_joints_are_near_everything,
    ),
    (
        Mutation(CollisionModel, "_bounds", "np.vecdot(self.levers, np.abs(q - self._at))", "0.0"),
        nothing_comes_near_unseen,
    ),
    (Mutation(ClearanceCache, "covers", "return used <= 1.0", "return True"), no_tool_leaves_its_box),
    (Mutation(ClearanceCache, "covers", "(abs(here - there) + more)", "more"), what_was_noted_elsewhere_does_not_count),
    (
        Mutation(ClearanceCache, "note", "if clearances.min(initial=math.inf) > 0.0:", "if True:"),
        no_room_covers_nothing,
    ),
    (
        Mutation(JointGuard, "check_finite", "broken = self._position(proposed, sent, spans)", "broken = None"),
        no_joint_runs_into_its_limit,
    ),
    (
        Mutation(JointGuard, "_position", " and excess > self._excess(sent, i) + POSITION", ""),
        lambda: test_guard.test_an_arm_outside_its_limits_may_only_retreat(guard_of()),
    ),
    (Mutation(Guard, "check", "self._clearance.clear(ends, doubtful)", "True"), no_tool_leaves_its_box),
    (
        Mutation(Guard, "check", "if not len(doubtful):", "if True:"),
        no_tool_leaves_its_box,
    ),
    (
        Mutation(ClearanceCheck, "_look", "[self._depth(q)]", "[1.0]"),
        no_tool_leaves_its_box,
    ),
    (
        Mutation(
            ClearanceCheck, "_look", "self.collision.clearances(q, reach, self._kept)", "self._levers[1:, 0] + 1.0"
        ),
        nothing_is_hit_at_rest,
    ),
    (
        Mutation(ClearanceCheck, "clear", "if not (self._clearances(last, doubtful) >= -POSITION).all():", "if False:"),
        nothing_is_hit_at_rest,
    ),
    (
        Mutation(JointGuard, "_position", "if lower + reach <= middle <= upper - reach:", "if True:"),
        no_joint_runs_into_its_limit,
    ),
    (
        Mutation(
            ClearanceCheck,
            "_clearances",
            "self.collision.distances(q, indices[indices > 0] - 1) - self._kept",
            "self.collision.distances(q, indices[indices > 0] - 1) + 1.0",
        ),
        nothing_is_hit_at_rest,
    ),
    (
        Mutation(ClearanceCheck, "_depth", "return ", "return 1.0 + "),
        no_tool_leaves_its_box,
    ),
    (
        Mutation(
            ClearanceCheck,
            "_doubtful",
            "indices[~enough]",
            "indices[:0]",
        ),
        nothing_is_hit_on_the_way_to_rest,
    ),
    (
        Mutation(
            ClearanceCheck,
            "_doubtful",
            "clearances >= travel - np.minimum(travel, TOLERANCE) - POSITION",
            "clearances >= -1.0",
        ),
        nothing_is_hit_on_the_way_to_rest,
    ),
    (
        Mutation(
            ClearanceCheck, "retreats", "return bool((self._worst(ends) >= allowed - POSITION).all())", "return True"
        ),
        an_arm_too_near_does_not_come_nearer,
    ),
    (
        Mutation(Guard, "check", "if self._clearance.retreats(ends, sent.q):", "if False:"),
        an_arm_too_near_does_not_come_nearer,
    ),
    (
        Mutation(CollisionModel, "distances", "if not math.isfinite(sum(q.tolist())):", "if False:"),
        broken_joints_are_near_everything,
    ),
    (
        Mutation(limits_module, "_widening", "if own[0] <= wanted[0] and wanted[1] <= own[1]:", "if True:"),
        configuration_never_widens,
    ),
]
IDS = [f"{m.function}: {m.check}" for m, _ in MUTATIONS]


@pytest.mark.parametrize(("mutation", "body"), MUTATIONS, ids=IDS)
def test_no_check_of_the_guard_can_be_taken_away(mutation, body, monkeypatch):
    body()
    mutation.apply(monkeypatch)
    with pytest.raises((AssertionError, ValueError, pytest.fail.Exception)):
        body()


def still(_t_ns):
    return (0.0, 0.0, 0.3)


def swaying(t_ns):
    t = t_ns / 1e9
    return (0.1 * np.sin(2.5 * t), 0.05 * np.sin(4 * t), 0.3 + 0.08 * np.sin(3 * t))


def engaged(motion=still):
    loop = RemoteLoop()
    loop.run(8 * 31, motion)
    assert loop.states[-1] is SessionState.ENGAGED
    return loop


def silence_holds():
    loop = engaged(swaying)
    loop.run(60)
    assert loop.states[-1] is SessionState.HOLDING


def a_link_regained_does_not_resume():
    loop = engaged(swaying)
    loop.run(200)
    at_rest = loop.sent.q.copy()
    loop.run(500, swaying)
    assert np.array_equal(loop.sent.q, at_rest)


def a_jump_moves_nothing():
    loop = engaged()
    start = loop.sent.q.copy()
    loop.run(16, lambda _t_ns: (0.4, 0.0, 0.3))
    loop.run(100)
    assert np.abs(loop.sent.q - start).max() < 1e-6


def a_late_sample_is_not_taken():
    loop = engaged()
    late = hand(5000, loop.clock.now_ns() - 150 * NS_PER_MS)
    loop.tick(late)
    assert loop.snapshot.rejected[Code.STALE] == 1


def an_older_number_is_not_taken():
    loop = engaged()
    before = loop.pipeline._latest
    loop.tick(hand(before.sample.seq - 3, loop.clock.now_ns(), (0.05, 0.0, 0.3)))
    assert loop.pipeline._latest is before


def staying_armed(self, why):
    self.state, self._reason, self._intent.armed = SessionState.DISENGAGED, why, True


SESSION = [
    (HandSignal, "unfit", lambda *_: None, silence_holds),
    (Session, "_leave", staying_armed, a_link_regained_does_not_resume),
    (SampleValidator, "_jump", lambda *_: None, a_jump_moves_nothing),
    (SampleValidator, "_time", lambda *_: None, a_late_sample_is_not_taken),
    (SampleValidator, "_order", lambda *_: None, an_older_number_is_not_taken),
]


@pytest.mark.parametrize(("owner", "check", "instead", "body"), SESSION, ids=[body.__name__ for *_, body in SESSION])
def test_no_check_of_intake_and_session_can_be_taken_away(owner, check, instead, body, monkeypatch):
    body()
    monkeypatch.setattr(owner, check, instead)
    with pytest.raises(AssertionError):
        body()


jerks = st.lists(st.floats(-1400, 1400), min_size=6, max_size=6)
broken = st.sampled_from([NAN, float("inf"), 1e6])


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.lists(st.tuples(jerks, st.integers(1, 12), st.none() | broken), max_size=12))
def test_whatever_is_proposed_the_driver_receives_what_can_stop_where_it_may_be(sequence):
    """The invariant on every command: finite, limits kept, and its jerk-limited stop inside joints, box and margins."""
    guard, around, sent = guard_of(), clearance(), JointMotion.at_rest(START)
    margin = around.collision.margin
    for values, ticks, spoilt in sequence:
        for _ in range(ticks):
            jerk = np.array(values)
            proposed = test_guard.after(sent)
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
    guard, left = guard_of(box=a_wall()), coasting(0.8)
    stop = guard.stop(left)
    assert isinstance(guard.check(stop, left), Passed)
    other = replace(stop, ddq=stop.ddq + 0.5)
    assert guard.check(other, left).reason.code in (Code.WORKSPACE, Code.INCONSISTENT)
