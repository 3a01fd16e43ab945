"""The FR3's driver on stepped time: its life, its faults by name, recovery only by an activation, its gripper."""

from dataclasses import replace

import numpy as np
import pytest

from common.errors import DriverError
from common.messages.robot import GripperCommand
from remote_site.drivers.conformance.checks import CHECKS, Check
from remote_site.drivers.conformance.suite import run_checks
from remote_site.drivers.franka.robot_limits import FR3
from remote_site.drivers.franka.robot_port import LinkLostError, MotionAbortedError, RobotRefusedError, UnreachableError
from remote_site.kinematics.joints import JointMotion
from tests.present import present
from tests.remote_site.drivers.franka.driven_arm import DrivenArm
from tests.remote_site.drivers.franka.fake_robot import (
    SAG,
    SETUP,
    FakeGripper,
    FakeRobot,
    SteppedSide,
    franka_stand,
    stepped_driver,
)

NAMES = [check.__name__ for check in CHECKS]
REFLEX = "motion aborted by reflex! [cartesian_reflex]"


@pytest.mark.slow
@pytest.mark.parametrize("check", CHECKS, ids=NAMES)
def test_it_conforms(check: Check) -> None:
    lines: list[str] = []
    assert run_checks(franka_stand(), lines.append, [check]) == [], lines


def sent_differences(robot: FakeRobot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The greatest speed, acceleration and jerk of what the robot was sent, as it differences them."""
    path = np.array([robot.sent[0], *robot.sent])
    return tuple(np.abs(np.diff(path, k, axis=0)).max(axis=0) / 0.001**k for k in (1, 2, 3))


def test_a_motion_begins_where_the_robot_holds_its_joints_and_keeps_within_its_limits() -> None:
    arm = DrivenArm().activate()
    begin = arm.robot.sent[0]
    assert np.allclose(begin, arm.read().q + SAG, atol=1e-6)
    arm.move(800)
    assert arm.code() == ""
    assert arm.robot.sent[-1][0] - begin[0] > 0.3
    assert np.allclose(arm.robot.sent[-1][1:], begin[1:], atol=1e-9)
    speed, acceleration, jerk = sent_differences(arm.robot)
    assert (speed <= FR3.velocity).all()
    assert (acceleration <= FR3.acceleration).all()
    assert (jerk <= FR3.jerk / 4).all()


def test_a_stop_ends_the_motion_at_rest_and_only_an_activation_begins_another() -> None:
    arm = DrivenArm().activate().move(400)
    arm.driver.stop()
    assert arm.code() == "stopped"
    arm.side.pass_ms(600)
    assert arm.robot.mode == "Idle"
    speed, acceleration, _ = sent_differences(arm.robot)
    assert np.abs(np.diff(arm.robot.sent[-15:], axis=0)).max() == 0.0
    assert (acceleration <= 1.5 * SETUP.limits.acceleration).all()
    assert speed[0] > 0.5
    with pytest.raises(DriverError, match="not active any more"):
        arm.write(JointMotion.at_rest(arm.read().q))
    arm.activate().move(40)
    assert arm.code() == ""
    assert arm.robot.calls == ["start", "start"]


def test_a_reflex_is_a_fault_by_its_name_and_is_recovered_from_by_an_activation_alone() -> None:
    arm = DrivenArm().activate().move(400)
    arm.robot.mode, arm.robot.errors = "Reflex", ("cartesian_reflex", "power_limit_violation")
    arm.robot.raises["read"] = MotionAbortedError(REFLEX)
    arm.side.pass_ms(100)
    fault = arm.read().fault
    assert fault is not None
    assert (fault.code.value, fault.native) == ("blocked", "cartesian_reflex")
    assert "cartesian_reflex, power_limit_violation: the tool was pushed or has hit something" in fault.sentence
    assert REFLEX in fault.sentence
    arm.driver.stop()
    arm.side.pass_ms(500)
    assert "recover" not in arm.robot.calls
    assert arm.code() == "blocked"
    arm.activate()
    assert arm.robot.calls == ["start", "recover", "start"]
    assert arm.code() == ""


def test_an_error_that_stays_after_recovery_refuses_the_activation() -> None:
    arm = DrivenArm()
    arm.robot.mode, arm.robot.errors, arm.robot.recovers = "Reflex", ("joint_position_limits_violation",), False
    arm.activate()
    assert arm.robot.calls == ["recover"]
    assert arm.code() == "limits"


@pytest.mark.parametrize(
    ("mode", "code"),
    [("UserStopped", "emergency_stop"), ("Guiding", "refused"), ("Other", "robot")],
)
def test_a_mode_without_motion_is_a_fault(mode: str, code: str) -> None:
    arm = DrivenArm()
    arm.robot.mode = mode
    arm.activate()
    assert (arm.code(), arm.robot.calls) == (code, [])


@pytest.mark.parametrize("call", ["start", "recover"])
def test_what_the_robot_refuses_is_said(call: str) -> None:
    arm = DrivenArm()
    arm.robot.errors = ("joint_reflex",)
    arm.robot.raises[call] = RobotRefusedError("no")
    arm.activate()
    fault = arm.read().fault
    assert fault is not None
    assert (fault.code.value, fault.sentence) == ("refused", "the robot refuses: no")


def test_a_lost_link_is_a_fault_and_a_reading_that_ages_until_it_is_back() -> None:
    arm = DrivenArm().activate().move(200)
    t_ns = arm.read().t_ns
    arm.robot.raises["read"] = LinkLostError("UDP receive: Timeout")
    arm.side.pass_ms(1)
    reading = arm.read()
    assert reading.fault is not None
    assert (reading.fault.code.value, reading.t_ns) == ("link", t_ns)
    assert reading.fault.sentence == "the robot does not answer any more (UDP receive: Timeout): check cable and power"
    arm.robot.mode = "Idle"
    arm.side.pass_ms(100)
    assert arm.read().t_ns > t_ns
    assert arm.code() == "link"
    assert arm.activate().code() == ""


def test_a_link_that_is_lost_with_the_motion_does_not_end_the_process() -> None:
    arm = DrivenArm().activate().move(200)
    arm.robot.raises["read"] = MotionAbortedError(REFLEX)
    arm.side.pass_ms(1)
    arm.robot.raises["read"] = LinkLostError("gone")
    arm.side.pass_ms(1)
    assert arm.code() == "link"


def test_an_activation_that_a_lost_link_overtook_moves_nothing_later() -> None:
    arm = DrivenArm()
    arm.driver.activate(arm.read().q)
    arm.robot.raises["read"] = LinkLostError("gone")
    arm.side.pass_ms(100)
    assert (arm.code(), arm.robot.calls) == ("link", [])


def test_a_link_that_cannot_be_made_again_says_why() -> None:
    arm = DrivenArm().activate().move(200)
    arm.robot.raises["read"] = UnreachableError("the robot at fake refuses the connection: activate FCI")
    arm.side.pass_ms(1)
    fault = arm.read().fault
    assert fault is not None
    assert fault.sentence == "the robot at fake refuses the connection: activate FCI"


def test_setpoints_that_cease_lead_to_rest() -> None:
    arm = DrivenArm().activate().move(400)
    arm.side.pass_ms(800)
    assert arm.code() == "watchdog"
    assert arm.robot.mode == "Idle"
    _, acceleration, _ = sent_differences(arm.robot)
    assert (acceleration <= 1.5 * SETUP.limits.acceleration).all()


def test_a_jump_is_never_sent() -> None:
    arm = DrivenArm().activate().move(400)
    last = arm.robot.sent[-1][0]
    arm.write(JointMotion.at_rest(arm.read().q + 0.5))
    arm.side.pass_ms(2)
    fault = arm.read().fault
    assert fault is not None
    assert fault.code.value == "limits"
    assert "of joint" in fault.sentence
    assert "the robot allows" in fault.sentence
    assert arm.robot.sent[-1][0] - last < 0.01
    arm.side.pass_ms(600)
    assert (sent_differences(arm.robot)[1] <= FR3.acceleration).all()


def test_milliseconds_that_the_process_misses_are_made_up_for() -> None:
    arm = DrivenArm().activate().move(400)
    before, at = arm.robot.sent[-2][0], arm.robot.sent[-1][0]
    arm.robot.lost_ticks = 4
    arm.side.pass_ms(1)
    assert arm.code() == ""
    assert arm.robot.sent[-1][0] - at == pytest.approx(5 * (at - before), rel=0.1)


def test_one_time_of_the_robots_that_lies_ahead_is_made_up_for_by_nothing() -> None:
    arm = DrivenArm().activate().move(400)
    arm.robot.ahead_ms = 10_000
    arm.side.pass_ms(1)
    arm.move(100)
    assert not arm.code()
    assert np.abs(np.diff(np.array(arm.robot.sent)[:, 0])).max() < 1.2e-3  # rad; in 10 s it would go a long way
    assert arm.read().t_ns > arm.side.now_ns() - 2e6


def test_an_arm_that_is_pushed_is_not_activated() -> None:
    arm = DrivenArm()
    arm.robot.held = arm.robot.held + np.array([0.2, *np.zeros(6)])
    arm.driver.activate(present(SETUP.start))
    arm.side.pass_ms(2)
    assert (arm.code(), arm.robot.calls) == ("apart", [])


def test_an_activation_while_the_last_motion_ends_begins_a_new_one() -> None:
    arm = DrivenArm().activate()
    arm.driver.stop()
    arm.driver.activate(arm.read().q)
    arm.side.pass_ms(2)
    assert arm.code() == "not_activated"
    arm.side.pass_ms(60)
    assert (arm.code(), arm.robot.calls) == ("", ["start", "start"])


def test_limits_without_room_for_late_setpoints_are_refused() -> None:
    hard = replace(SETUP, limits=replace(SETUP.limits, acceleration=np.full(7, 9.0)))
    with pytest.raises(DriverError, match="acceleration of fr3_joint1 is 9, and more than 6 rad/s² leaves no room"):
        stepped_driver(SteppedSide(FakeRobot(), None)).configure(hard)


def test_a_robot_that_does_not_answer_ends_the_configuration_with_why() -> None:
    silent = SteppedSide(FakeRobot(), None)
    silent.failed = "the robot at fake refuses the connection: activate FCI in its page Desk"
    with pytest.raises(DriverError, match=r"^the robot at fake refuses"):
        stepped_driver(silent).configure(SETUP)
    assert silent.ended


def test_a_process_that_died_is_a_fault() -> None:
    arm = DrivenArm().activate()
    arm.side.failed = "franka: process arm died (exit code -9)"
    arm.side.pass_ms(60)
    fault = arm.read().fault
    assert fault is not None
    assert (fault.code.value, fault.sentence) == ("process", arm.side.failed)


def test_the_gripper_obeys_each_change_once_and_is_not_measured_meanwhile() -> None:
    arm = DrivenArm(gripper=FakeGripper(object_m=0.03)).activate()
    rest = JointMotion.at_rest(arm.read().q)
    arm.side.pass_ms(20)
    assert arm.read().gripper is not None
    for command in (GripperCommand.KEEP, GripperCommand.CLOSED, GripperCommand.CLOSED, GripperCommand.KEEP):
        arm.write(rest, command)
        if command is GripperCommand.CLOSED and not arm.gripper.calls:
            assert arm.read().gripper is None
        arm.side.pass_ms(20)
    arm.write(rest, GripperCommand.OPEN)
    arm.side.pass_ms(20)
    assert arm.gripper.calls == [f"close {SETUP.grip_force_n:g}", "open 0.08"]
    grip = arm.read().gripper
    assert grip is not None
    assert (grip.opening_m, grip.force_n) == (0.08, None)


def test_a_gripper_that_was_not_homed_is_not_sent_to_its_unknown_width() -> None:
    arm = DrivenArm(gripper=FakeGripper(widest_m=0.0)).activate()
    arm.write(JointMotion.at_rest(arm.read().q), GripperCommand.OPEN)
    arm.side.pass_ms(40)
    assert arm.gripper.calls == []
    grip = arm.read().gripper
    assert grip is not None
    assert grip.opening_m == 0.04


@pytest.mark.parametrize("error", [RobotRefusedError("not homed"), LinkLostError("gone")])
def test_a_gripper_that_fails_stops_no_arm(error: DriverError) -> None:
    arm = DrivenArm(gripper=FakeGripper(raises=error)).activate()
    arm.side.pass_ms(20)
    arm.write(JointMotion.at_rest(arm.read().q), GripperCommand.CLOSED)
    arm.side.pass_ms(40)
    assert arm.gripper.calls[0] == f"close {SETUP.grip_force_n:g}"
    assert arm.code() == ""
