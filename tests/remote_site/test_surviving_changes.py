"""Changes that once went unnoticed: each makes the test beside it fail."""

from collections.abc import Callable

import numpy as np
import pytest

from common.messages.robot import SessionState
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.drivers.supervisor.write_scheduler import WriteScheduler
from remote_site.kinematics.joints import JointMotion
from remote_site.motion import jerk_limited
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.motion.planner import MotionPlanner
from remote_site.reasons import Code
from remote_site.safety.clearance import ClearanceCheck, Workspace
from remote_site.safety.config import SafetyConfig
from remote_site.safety.guard import Passed
from remote_site.safety.stopping import stops
from remote_site.session import requests as requests_module
from remote_site.session.samples import Accepted, NamedSample, Rejected
from remote_site.session.state_machine import Session
from remote_site.teleop.cycle import CycleInput, RobotObservation
from remote_site.teleop.pipeline import TeleopPipeline
from remote_site.teleop.sample_validator import SampleValidator
from tests.remote_site.drivers.supervisor.supervised import Supervised
from tests.remote_site.drivers.supervisor.test_faults import test_the_first_fault_is_kept as keeps_the_first_fault
from tests.remote_site.mutation import Mutation
from tests.remote_site.remote_loop import REFUSALS, TICK_NS, RemoteLoop, arm, clearance, hand, operator_of
from tests.remote_site.session.session_rig import READY, SessionRig, engaged, held
from tests.remote_site.session.test_requests import OTHER, RESET, ask

DT = 0.004
MODEL, LIMITS = arm()
START = np.radians([0.0, 0.0, -45.0, 0.0, -45.0, 0.0])


def still(_t_ns: int) -> tuple[float, float, float]:
    return (0.0, 0.0, 0.3)


def test_the_pipeline_leashes_the_target_to_the_measured_arm() -> None:
    loop = RemoteLoop()
    loop.run(8 * 31, still)
    measured, sent = loop.sent.q, loop.sent
    for k in range(300):
        now_ns = loop.clock.now_ns() + k * TICK_NS
        robot = RobotObservation(measured, None, sent, None)  # the arm stays, whatever it is commanded
        sample = NamedSample(operator_of(7), hand(1000 + k, now_ns - TICK_NS, (0.0, -0.001 * k, 0.3)))
        samples = (sample,) if k % 8 == 0 else ()
        command = loop.pipeline.cycle(CycleInput(now_ns, robot, loop.leases.status(now_ns), samples))
        sent = command.motion
    assert np.abs(sent.q - measured).max() > 0.02
    lead = np.linalg.norm(command.snapshot.target[:3, 3] - MODEL.forward(measured)[:3, 3])
    assert lead == pytest.approx(loop.config.control.leash_m)


@pytest.mark.parametrize("moving", [-0.7, 0.0, 0.7])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_moving_target_is_approached_at_full_speed_and_no_faster(moving: float, side: float) -> None:
    tracker, most = JerkLimitedTracker(LIMITS, DT), LIMITS.velocity[0]
    tracker.reset(JointMotion.at_rest(np.zeros(6)))
    axis, speeds = np.eye(6)[0], []
    for k in range(400):
        target = (4.0 * side + moving * most * k * DT) * axis
        motion = tracker.track(JointMotion(target, moving * most * axis, np.zeros(6)))
        assert isinstance(motion, JointMotion)
        speeds.append(motion.dq[0])
    assert max(side * np.array(speeds)) == pytest.approx(most, rel=1e-6)
    assert np.abs(speeds).max() <= most * (1 + 1e-6)


def test_what_is_written_never_goes_back_in_the_plan() -> None:
    rng, scheduler, now_ns = np.random.default_rng(5), WriteScheduler[int](), 0
    scheduler.restart(0, 0)
    planned = [0]
    for _ in range(2000):
        now_ns += int(rng.integers(0, 6_000_000))
        plan_ns = planned[-1] + int(rng.integers(-8_000_000, 8_000_000))
        match rng.integers(0, 4):
            case 0:
                scheduler.add(plan_ns, 0)
            case 1:
                scheduler.reach(plan_ns, now_ns)
            case 2:
                scheduler.delay(int(rng.integers(0, 3_000_000)))
            case _:
                scheduler.take(now_ns)
        planned.append(scheduler.planned_ns)
    assert (np.diff(planned) >= 0).all()
    assert planned[-1] > 0


def test_control_plans_on_from_what_was_really_sent() -> None:
    loop = RemoteLoop()
    loop.run(8 * 31, still)
    loop.run(120, lambda t_ns: (0.06 * np.sin(4e-9 * t_ns), 0.0, 0.3))
    sent = loop.sent
    for k in range(8):
        now_ns = loop.clock.now_ns() + (k + 1) * TICK_NS
        sent = loop.guard.stop(sent)  # the driver's process has begun to stop the arm
        robot = RobotObservation(sent.q, None, sent, None)
        command = loop.pipeline.cycle(CycleInput(now_ns, robot, loop.leases.status(now_ns)))
        assert isinstance(loop.guard.check(command.motion, sent), Passed)
        assert command.snapshot.reason.code not in REFUSALS  # planned from another motion, it would be refused
        sent = command.motion


def test_a_fault_withdraws_what_the_operator_asked_for() -> None:
    rig = held()
    rig.session.fault("x", rig.now_ns)
    assert not rig.session.held
    rig = SessionRig()
    rig.frames(29)
    rig.session.fault("x", rig.now_ns)
    rig.session.reset()
    assert rig.frames(90).state is SessionState.DISENGAGED


def test_a_path_that_is_worse_in_the_middle_is_no_retreat() -> None:
    depth = MODEL.forward(START)[0, 3]
    outside = Workspace(np.array([depth + 0.02, -2.0, -2.0]), np.array([3.0, 2.0, 3.0]))
    motion = JointMotion(START, np.array([0.0, 0.438, -0.863, 0.0, 0.0, 0.0]), np.zeros(6))
    ends, at_end = stops(motion, LIMITS), [stop.end for stop in stops(motion, LIMITS)]
    assert MODEL.forward(np.array(at_end))[0, 3] > depth  # it ends less far outside than it begins
    assert not clearance(box=outside).retreats(ends, START)


def test_the_first_fault_is_the_one_that_is_shown() -> None:
    keeps_the_first_fault(Supervised())
    rig = engaged()
    rig.session.fault("the brakes failed", rig.now_ns)
    rig.session.fault("no command for 102 ms", rig.now_ns)
    assert "brakes" in rig.frames(1).reason.sentence


def test_after_a_jump_has_latched_the_hand_is_believed_where_it_is() -> None:
    validator = SampleValidator(SafetyConfig())
    now_ns = 10**10
    results: list[Accepted | Rejected] = []
    for k in range(6):
        now_ns += 33_000_000
        wrist = (0.0, 0.0, 0.3) if k == 0 else (0.9, 0.0, 0.3)
        results.append(validator.accept(hand(k + 1, now_ns - 8_000_000, wrist), 100_000_000, now_ns))
    codes = [result.reason.code if isinstance(result, Rejected) else None for result in results]
    assert codes == [None, Code.JUMP, Code.JUMP, Code.JUMPS, None, None]


def test_only_the_holder_and_maintenance_may_reset() -> None:
    rig = engaged()
    rig.session.stop("anna", rig.now_ns)
    outcome = ask(rig, RESET, OTHER)
    assert (outcome.answer.done, outcome.answer.reason.code) == (False, Code.NOT_HOLDER)
    assert not rig.session.request_engage(rig.now_ns, READY).done


CHANGES: list[tuple[object, str, str, str, Callable[[], None]]] = [
    (
        TeleopPipeline,
        "_plan",
        "_tool_sample(latest, settings, robot,",
        "_tool_sample(latest, settings, robot._replace(q=sent.q),",
        test_the_pipeline_leashes_the_target_to_the_measured_arm,
    ),
    (
        jerk_limited,
        "seen_from",
        "lower - velocity",
        "lower + velocity",
        lambda: test_a_moving_target_is_approached_at_full_speed_and_no_faster(0.7, -1.0),
    ),
    (
        jerk_limited,
        "seen_from",
        "lower - velocity",
        "lower",
        lambda: test_a_moving_target_is_approached_at_full_speed_and_no_faster(-0.7, -1.0),
    ),
    (
        WriteScheduler,
        "reach",
        "max(min(planned_ns, furthest_ns), self._planned_ns)",
        "min(planned_ns, furthest_ns)",
        test_what_is_written_never_goes_back_in_the_plan,
    ),
    (
        WriteScheduler,
        "add",
        "if planned_ns > self._planned_ns:",
        "if True:",
        test_what_is_written_never_goes_back_in_the_plan,
    ),
    (
        MotionPlanner,
        "follow",
        "self._jerk_limited.reset(sent)",
        "pass",
        test_control_plans_on_from_what_was_really_sent,
    ),
    (Session, "_bar", "self._intent.end()", "pass", test_a_fault_withdraws_what_the_operator_asked_for),
    (ClearanceCheck, "_worst", "RETREAT_CHECKS", "2", test_a_path_that_is_worse_in_the_middle_is_no_retreat),
    (
        DriverSupervisor,
        "_fail",
        "if self.fault is None or self.fault.calm:",
        "if True:",
        test_the_first_fault_is_the_one_that_is_shown,
    ),
    (
        Session,
        "fault",
        "if self.state is SessionState.FAULT:",
        "if False:",
        test_the_first_fault_is_the_one_that_is_shown,
    ),
    (
        SampleValidator,
        "_jumped",
        "self._last, self._jumps = None, 0",
        "self._jumps = 0",
        test_after_a_jump_has_latched_the_hand_is_believed_where_it_is,
    ),
    (
        requests_module,
        "_refusal",
        "if request.maintenance:",
        "if request.maintenance or request.action is EngagementAction.RESET:",
        test_only_the_holder_and_maintenance_may_reset,
    ),
]
IDS = [f"{function}: {text} -> {instead}" for _, function, text, instead, _ in CHANGES]


@pytest.mark.parametrize(("owner", "function", "text", "instead", "body"), CHANGES, ids=IDS)
def test_the_change_is_noticed(
    owner: object, function: str, text: str, instead: str, body: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    body()
    Mutation(owner, function, text, instead).apply(monkeypatch)
    with pytest.raises(AssertionError):
        body()
