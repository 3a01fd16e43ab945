"""Every check of guard and clearance is needed: with any one taken away, the test named beside it fails."""

import pytest

from remote_site.config import RemoteConfig
from remote_site.kinematics import limits as limits_module
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code
from remote_site.safety.clearance import ClearanceCheck
from remote_site.safety.collision import ClearanceCache, CollisionModel
from remote_site.safety.config import CollisionConfig, FixtureConfig, SafetyConfig
from remote_site.safety.guard import Guard, JointGuard, Passed
from tests.remote_site.kinematics import test_arm_model
from tests.remote_site.mutation import Mutation
from tests.remote_site.remote_loop import guard_of
from tests.remote_site.safety import test_collision, test_guard
from tests.remote_site.safety.test_guard import LIMITS, START, a_wall

NAN = float("nan")


def a_post(thickness=0.01):
    """Surroundings with a thin post between two places that are clear."""
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
    test_arm_model.test_an_attempt_to_widen_names_every_joint_and_value()


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
