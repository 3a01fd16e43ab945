"""The processes beside the driver end at once, also within calls of the client that wait for a robot or its fingers."""

import time

import pytest
from structlog.testing import capture_logs

from common.host_clock import MonotonicClock
from common.process.children import END_TIMEOUT_S
from lab.stage.waiting import until
from remote_site.drivers.franka import robot_side
from remote_site.drivers.franka.config import FrankaConfig
from remote_site.drivers.franka.robot_port import ArmState, UnreachableError
from remote_site.drivers.franka.robot_side import RobotProcesses
from tests.remote_site.drivers.franka.fake_robot import SETUP, FakeRobot

CONFIG = FrankaConfig(host="fr3")
IN_THE_CALL_S = 0.3


class Waiting:
    """Does not return, whatever signal has a handler."""

    def __init__(self, host: str, *, realtime: bool = True) -> None:
        assert (host, realtime) == ("fr3", True)
        while True:
            time.sleep(1.0)


class Refusing:
    def __init__(self, host: str, *, realtime: bool) -> None:
        raise UnreachableError(f"the robot at {host} refuses ({realtime})")


class Answering(FakeRobot):
    def __init__(self, host: str, *, realtime: bool) -> None:
        super().__init__()
        assert (host, realtime) == ("fr3", True)

    def read(self) -> ArmState:
        time.sleep(0.001)
        return super().read()


@pytest.mark.slow
@pytest.mark.parametrize("robot", [Waiting, Answering])
def test_both_end_while_they_wait(robot: type, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_side, "FrankaRobot", robot)
    monkeypatch.setattr(robot_side, "FrankaGripper", Waiting)
    side = RobotProcesses(CONFIG, MonotonicClock())
    side.start(SETUP)
    time.sleep(IN_THE_CALL_S)
    began = time.monotonic()
    with capture_logs() as logs:
        side.end()
    assert logs == []
    assert time.monotonic() - began < END_TIMEOUT_S
    assert side.failure() == ""


def test_why_there_is_no_connection_is_all_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_side, "FrankaRobot", Refusing)
    side = RobotProcesses(FrankaConfig(host="fr3", gripper=False), MonotonicClock())
    side.start(SETUP)
    until(side.failure, "the refusal", 10.0)
    assert side.failure() == "the robot at fr3 refuses (True)"
    side.end()
