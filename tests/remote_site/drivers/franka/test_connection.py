"""How the arm's process begins and ends: the first connection has to succeed, later ones are tried again."""

import pytest

from common.errors import DriverError
from common.process.service import StopFlag
from remote_site.drivers.franka.arm_loop import run_arm_loop
from remote_site.drivers.franka.robot_port import LinkLostError, RobotPort, RobotRefusedError
from remote_site.drivers.franka.robot_watch import connected_once
from tests.remote_site.drivers.franka.driven_arm import DrivenArm
from tests.remote_site.drivers.franka.fake_robot import FakeRobot


class Door:
    """Opens, or not."""

    def __init__(self, error: DriverError | None = None) -> None:
        self.error = error

    def __call__(self) -> RobotPort:
        if self.error is not None:
            raise self.error
        return FakeRobot()


def test_a_first_connection_that_fails_says_what_to_do() -> None:
    with pytest.raises(DriverError, match="cannot be reached: refused; is FCI active in Desk") as raised:
        connected_once(Door(LinkLostError("refused")))()
    assert not isinstance(raised.value, LinkLostError)


def test_a_kernel_without_real_time_is_not_called_a_robot_out_of_reach() -> None:
    with pytest.raises(DriverError, match=r"^the kernel has no real time$"):
        connected_once(Door(DriverError("the kernel has no real time")))()


@pytest.mark.parametrize("error", [LinkLostError("gone"), RobotRefusedError("busy")])
def test_a_later_one_is_tried_again(error: DriverError) -> None:
    door = Door()
    connect = connected_once(door)
    connect()
    door.error = error
    with pytest.raises(LinkLostError):
        connect()


def test_the_process_ends_when_the_arm_rests() -> None:
    arm, should_stop = DrivenArm().activate().move(400), StopFlag()
    loop = arm.side.loop
    assert loop is not None
    should_stop.set()
    run_arm_loop(loop, should_stop, lambda: arm.side.advance_ms(1))
    assert arm.robot.mode == "Idle"
    assert max(abs(arm.robot.sent[-1] - arm.robot.sent[-2])) == 0.0
