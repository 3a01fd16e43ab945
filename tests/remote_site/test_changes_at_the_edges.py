"""Small changes at the edges of what moves the arm, which no other test notices: each makes a test here fail."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.host_clock import MonotonicClock
from common.messages.requests import EngagementAction
from common.messages.robot import AssistPhase, GripperCommand, SessionState
from lab.stage.waiting import until
from remote_site.drivers.driver import Capabilities, GripperReading, JointCommand, RobotReading
from remote_site.drivers.faults import RobotFault
from remote_site.drivers.franka.setpoint_filter import SetpointFilter
from remote_site.drivers.position_arm.arm import PositionArm
from remote_site.drivers.position_arm.calls import ArmCallError, ArmCalls
from remote_site.drivers.position_arm.threaded_calls import ThreadedCalls
from remote_site.drivers.supervisor.reading_check import FASTEST, ReadingCheck
from remote_site.drivers.supervisor.watched_driver import WatchedDriver
from remote_site.drivers.supervisor.writer import PacedWriter
from remote_site.kinematics.config import SingularityConfig, SolverConfig
from remote_site.kinematics.dexterity import Dexterity
from remote_site.kinematics.differential import ACCELERATE, DifferentialInverse, Move
from remote_site.kinematics.inverse import Solution, SphericalWristInverse
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import TARGET_SPEED, stoppable
from remote_site.motion.joint_path import JointPath
from remote_site.motion.moving_frame import AxisLimits, frame_of
from remote_site.motion.planner import MotionPlanner
from remote_site.motion.target_path import TargetPath
from remote_site.motion.target_predictor import JointBounds
from remote_site.motion.tool_shift import fastest_alone
from remote_site.reasons import Code
from remote_site.safety.guard import JointGuard, Refused
from remote_site.teleop.hold_offset import SLOW_FRACTION, shortened
from remote_site.teleop.tool_target import ToolTarget
from tests.present import present
from tests.remote_site.assist.sightings import PRESSED
from tests.remote_site.assist.test_assist_in_pipeline import AssistLoop
from tests.remote_site.drivers.supervisor.supervised import SETUP, START
from tests.remote_site.remote_loop import RemoteLoop, arm

MODEL, LIMITS = arm()
DT = 0.004
BENT = np.radians([0.0, 20.0, -60.0, 0.0, -45.0, 0.0])


def still(_t_ns: int) -> tuple[float, float, float]:
    return (0.0, 0.0, 0.3)


def swinging(t_ns: int) -> tuple[float, float, float]:
    return (0.04 * math.sin(4.0 * t_ns / NS_PER_S), 0.0, 0.3)


def test_an_offset_is_shortened_more_slowly_towards_its_end_and_ends() -> None:
    half = np.array([0.5 * SLOW_FRACTION, 0.0, 0.0])
    assert shortened(half, 0.02)[0] == pytest.approx(half[0] - 0.01)
    assert shortened(np.array([1e-3, 0.0, 0.0]), 0.02).tolist() == [0.0, 0.0, 0.0]
    assert shortened(np.zeros(3), 0.0).tolist() == [0.0, 0.0, 0.0]


def test_the_planner_is_told_in_which_ticks_a_sample_came(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[bool] = []
    follow = MotionPlanner.follow

    def noted(self: MotionPlanner, *given: Any, aimed: bool) -> Any:
        told.append(aimed)
        return follow(self, *given, aimed=aimed)

    loop = RemoteLoop()
    loop.run(8 * 31, still)
    monkeypatch.setattr(MotionPlanner, "follow", noted)
    loop.run(80, swinging)
    assert len(told) == 80
    assert sum(told) == 10  # a sample each eight ticks


def test_the_arm_is_ready_again_once_it_was_sent_to_rest_and_not_sooner() -> None:
    loop = RemoteLoop()
    loop.run(8 * 60, swinging)
    loop.ask(EngagementAction.DISENGAGE)
    moving = []
    for _ in range(200):
        loop.run(1, swinging)
        moving.append((loop.snapshot.readiness.reason.code == Code.MOVING, not loop.sent.resting))
    assert any(rests for _, rests in moving)
    assert all(told == true for told, true in moving)


def test_a_new_engagement_after_an_assist_takes_its_origins_once(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = AssistLoop()
    loop.go(2.5)
    loop.go(0.5, PRESSED)
    assert present(loop.snapshot.assist).phase is AssistPhase.LEADING
    loop.ask(EngagementAction.DISENGAGE)
    loop.go(1.0)
    taken: list[object] = []
    monkeypatch.setattr(ToolTarget, "rebase", lambda *given: taken.append(given))
    assert loop.ask(EngagementAction.ENGAGE).done
    loop.go(0.5)
    assert loop.snapshot.state is SessionState.ENGAGED
    assert taken == []  # it would leave out what the hand did since


def test_mirrored_joints_have_mirrored_frames() -> None:
    rng = np.random.default_rng(1)
    limits = AxisLimits(3.0, 10.0, 200.0, 0.05)
    for _ in range(2000):
        target, joint = (tuple((rng.uniform(-1, 1, 3) * (0.2, 3.0, 3.0)).tolist()) for _ in range(2))
        frame = frame_of(target, joint, limits)
        mirrored = frame_of(tuple(-v for v in target), tuple(-v for v in joint), limits)
        expected = (-frame.position, -frame.velocity, -frame.acceleration, -frame.lowest, -frame.highest)
        assert mirrored == pytest.approx(expected)


def test_a_frame_gains_half_of_the_velocity_that_is_left_before_the_limit() -> None:
    limits = AxisLimits(3.0, 10.0, 200.0, 0.05)
    target, joint = (0.0, 1.0, 0.9), (0.0, 2.95, 0.0)  # the joint leaves less than its target
    assert frame_of(target, joint, limits).acceleration == pytest.approx((3.0 - 2.95) / (2 * 0.05))


def test_the_path_goes_over_to_samples_by_the_interval_at_which_they_come() -> None:
    path = TargetPath(DT)
    for k in range(100):
        path.add(k * NS_PER_S // 100, np.zeros(6))
    for _ in range(100):
        path.predict(np.ones(6), np.zeros(6))
    pose, _ = path.at(99 * NS_PER_S // 100, 0.03)
    assert pose == pytest.approx(np.zeros(6), abs=1e-6)  # three intervals late: of samples alone


def test_no_target_has_a_velocity_from_which_its_joint_cannot_stop() -> None:
    bounds, fastest = JointBounds(MODEL, LIMITS, 8.0), TARGET_SPEED * LIMITS.velocity
    for share in np.linspace(0.0, 1.0, 401).tolist():
        q = LIMITS.lower + share * (LIMITS.upper - LIMITS.lower)
        for side in (-1.0, 1.0):
            _, dq = bounds.clamp(q.tolist(), (2 * side * fastest).tolist())
            room = LIMITS.upper - q if side > 0 else q - LIMITS.lower
            joints = zip(room, LIMITS.acceleration, LIMITS.jerk, strict=True)
            most = np.minimum(fastest, [stoppable(float(ahead), float(a), float(j)) for ahead, a, j in joints])
            assert side * np.array(dq) == pytest.approx(most)


def test_the_fastest_that_one_joint_moves_the_tool_is_its_own_speed_over_all_axes() -> None:
    assert fastest_alone(np.array([[3.0, 0.0], [4.0, 0.0], [0.0, 1.0]])) == pytest.approx(5.0)


def test_a_knot_has_the_speed_of_the_tool_and_no_turn_in_it() -> None:
    path, q = JointPath(MODEL, LIMITS), BENT
    path.begin(q, 0, 0.0, np.zeros(6), 0.0)
    knot = path.straight_on(q + 0.01, NS_PER_S // 30)
    twist = MODEL.jacobian(q + 0.01) @ knot.chord
    assert knot.tool == pytest.approx((np.linalg.norm(twist[:3]), np.linalg.norm(twist[3:])))


def test_of_two_solutions_for_one_time_the_first_counts() -> None:
    path, q = JointPath(MODEL, LIMITS), BENT
    path.begin(q, 0, 0.0, np.zeros(6), 0.0)
    path.add(q + 0.01, NS_PER_S // 30)
    path.add(q + 0.02, NS_PER_S // 30)
    assert len(path.knots) == 2


def test_of_a_stretched_arm_the_condition_is_infinite() -> None:
    dexterity = Dexterity(MODEL, SingularityConfig())
    assert dexterity.condition(np.zeros(6)) == math.inf
    assert dexterity.condition(BENT) < 100.0


def test_the_general_solver_changes_no_joint_faster_than_it_can_accelerate() -> None:
    inverse = DifferentialInverse(MODEL, LIMITS, SolverConfig(), SingularityConfig(), BENT)
    target = MODEL.forward(BENT)
    target[:3, 3] += (0.0, 0.3, 0.0)
    move = inverse.step(Move.at_rest(BENT), target, np.zeros(6), 1.0, DT, None)
    assert np.max(np.abs(move.dq) / LIMITS.acceleration) == pytest.approx(ACCELERATE * DT)


def test_where_the_wrist_is_nearly_straight_joint_4_goes_to_the_goal_nearer_to_its_middle() -> None:
    """From 100 deg, 180 deg would be nearer than 0; from there it would be at its end."""
    straight = np.radians([0.0, 20.0, -60.0, 100.0, 11.0, 0.0])
    goal = straight + np.radians([0.0, 0.0, 0.0, 75.0, 0.0, 0.0])
    found = SphericalWristInverse(MODEL, LIMITS).nearest(MODEL.forward(goal), straight)
    assert isinstance(found, Solution)
    assert found.q[3] < straight[3]


def refused(proposed: JointMotion, sent: JointMotion) -> Refused:
    judged = JointGuard(LIMITS, DT).check(proposed, sent)
    assert isinstance(judged, Refused)
    return judged


def test_all_of_the_speed_counts_that_remains_when_the_acceleration_is_taken_back() -> None:
    acceleration = 0.5 * LIMITS.acceleration
    gained = acceleration**2 / (2 * LIMITS.jerk)
    motion = JointMotion(BENT, LIMITS.velocity - 0.8 * gained, acceleration)
    assert refused(motion, motion).reason.code is Code.VELOCITY


def test_a_refused_jerk_is_told_by_the_second() -> None:
    jump = np.array([1.5 * LIMITS.jerk[0] * DT, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert jump[0] < LIMITS.acceleration[0]
    told = refused(JointMotion(BENT, np.zeros(6), jump), JointMotion.at_rest(BENT)).reason
    assert told.code is Code.JERK
    assert f"{1.5 * LIMITS.jerk[0]:.1f} rad/s³" in told.sentence


def test_after_a_pause_the_jerk_to_a_setpoint_is_that_of_one_that_came_two_periods_late() -> None:
    def ddq(elapsed_s: float) -> list[float]:
        led, written_ns = SetpointFilter(BENT, LIMITS, DT), round(elapsed_s * NS_PER_S)
        led.add(JointMotion(BENT, np.full(6, 0.01), np.full(6, 0.01)), 1, written_ns)
        for ms in range(3):
            led.step(written_ns + ms * NS_PER_MS)
        return list(led.motion.ddq)

    assert ddq(5 * DT) == ddq(2 * DT)
    assert ddq(2 * DT) != ddq(1.5 * DT)


@pytest.mark.parametrize(("times", "can_be"), [(0.8, True), (1.2, False)])
def test_a_speed_can_be_read_as_ten_times_the_joints_own(times: float, *, can_be: bool) -> None:
    capabilities = Capabilities(1000.0, None, gripper=True, force=True, watchdog_ms=None)
    dq = np.array([times * FASTEST * SETUP.joint_range.velocity[0], 0.0, 0.0, 0.0, 0.0, 0.0])
    read = RobotReading(NS_PER_S, START, dq, GripperReading(0.05, None), None, None)
    assert isinstance(ReadingCheck(capabilities, SETUP).judge(read, NS_PER_S), RobotFault) is not can_be


def test_a_joint_whose_range_lies_above_zero_slows_down_before_its_lower_limit() -> None:
    q = BENT + np.array([2.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    limits = replace(LIMITS, lower=np.array([q[0] - 0.01, *LIMITS.lower[1:]]))
    inverse = DifferentialInverse(MODEL, limits, SolverConfig(), SingularityConfig(), q)
    last = replace(Move.at_rest(q), dq=np.array([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    move = inverse.step(last, MODEL.forward(BENT), np.zeros(6), 1.0, DT, None)
    assert move.dq[0] > -0.5


class UnclosableArm(PositionArm):
    """Rests at zero; it cannot be let go of."""

    joints, rate_hz, threaded = 6, 100.0, True

    def __init__(self) -> None:
        self.readings = 0

    def read(self) -> list[float]:
        self.readings += 1
        return [0.0] * 6

    def write(self, _positions: Any) -> None: ...

    def stop(self) -> None: ...

    def close(self) -> None:
        raise OSError("the port is gone")


class RestlessClock(MonotonicClock):
    """Notes who sleeps."""

    slept = 0

    def sleep_until_ns(self, deadline_ns: int) -> None:
        self.slept += 1
        super().sleep_until_ns(deadline_ns)


def test_a_thread_rests_between_calls_only_where_one_has_failed_and_tells_what_the_last_one_met() -> None:
    arm, clock = UnclosableArm(), RestlessClock()
    calls = ThreadedCalls(ArmCalls(arm, clock), clock)
    until(lambda: calls.measure() and arm.readings > 5)
    assert clock.slept == 0
    with pytest.raises(ArmCallError, match="close raised OSError: the port is gone"):
        calls.end(stops=False)


def test_a_robot_that_was_sent_on_has_to_follow_anew_until_it_has_settled() -> None:
    slow = Capabilities(50.0, None, gripper=True, force=True, watchdog_ms=None)
    writer = PacedWriter(cast("WatchedDriver", SimpleNamespace(write=lambda _command: None)), slow, SETUP)
    still, moving = np.zeros(6), np.full(6, 0.01)
    begin = JointCommand(7, 0, START, still, still, GripperCommand.KEEP)
    writer.restart(begin, 0)
    assert writer.command is begin
    assert not writer.settled(0)
    writer.add(replace(begin, seq=8, dq=moving))
    writer.step(None, 20 * NS_PER_MS)
    assert not writer.settled(20 * NS_PER_MS)
    writer.add(replace(begin, seq=9))
    writer.step(None, 40 * NS_PER_MS)
    assert not writer.settled(45 * NS_PER_MS)
    assert writer.settled(45 * NS_PER_MS + 2 * writer.period_ns)
