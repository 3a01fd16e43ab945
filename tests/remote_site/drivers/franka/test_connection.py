"""How the arm's process begins and ends: the first connection has to succeed, later ones are tried again."""

import pytest

from common.errors import DriverError
from common.process.service import StopFlag
from remote_site.drivers.franka.arm_loop import run_arm_loop
from remote_site.drivers.franka.connecting import connection_error
from remote_site.drivers.franka.robot_port import LinkLostError, RobotPort, UnreachableError
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


@pytest.mark.parametrize(
    ("said", "sentence"),
    [
        ("Connection error: Host not found", "the address fr3 of the robot is not known: correct driver.options.host"),
        ("Connection to FCI refused. Please install FCI feature or enable FCI mode in Desk.", "activate FCI"),
        ("Connection timeout. Please check your network connection or settings.", "check its power, the cable"),
        ("TCP connection got interrupted.", "the robot at fr3 does not answer: check its power"),
        ("Connection error: Net Exception: Network is unreachable", "in no network of this machine"),
        (
            "Incompatible library version (server version: 9, library version: 10). Please",
            "install the pylibfranka that",
        ),
        (
            "Protocol error during connection attempt",
            "reached (Protocol error during connection attempt): see its page",
        ),
    ],
)
def test_a_connection_that_fails_is_one_sentence_with_the_address_and_the_cure(said: str, sentence: str) -> None:
    error = connection_error("fr3", f"libfranka: {said}")
    assert isinstance(error, UnreachableError)
    assert sentence in str(error)
    assert " fr3 " in str(error)
    assert str(error).count(": ") == 1


def test_a_first_connection_that_fails_ends_the_process_with_its_sentence() -> None:
    with pytest.raises(DriverError, match=r"^no link$") as raised:
        connected_once(Door(UnreachableError("no link")))()
    assert not isinstance(raised.value, LinkLostError)


def test_a_kernel_without_real_time_is_not_called_a_robot_out_of_reach() -> None:
    error = connection_error("127.0.0.1", "libfranka: Running kernel does not have realtime capabilities.")
    assert not isinstance(error, LinkLostError)
    with pytest.raises(DriverError, match=r"kernel has no real time, .* 127\.0\.0\.1: run a PREEMPT_RT kernel"):
        connected_once(Door(error))()


def test_a_later_one_is_tried_again() -> None:
    door = Door()
    connect = connected_once(door)
    connect()
    door.error = UnreachableError("gone")
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
