"""Faults of robot, driver and commands: each stops the arm and stays until the next activation."""

import numpy as np
import pytest

from common.errors import DriverError
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.supervisor.state import SupervisorState
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stop_time, stopping
from tests.remote_site.drivers.supervisor.supervised import LIMITS, Supervised, assert_smooth


@pytest.mark.parametrize("change", [0.01, 0.5, np.nan, np.inf])
def test_a_command_beyond_the_limits_never_reaches_the_robot_and_ends_in_the_stop(
    rig: Supervised, change: float
) -> None:
    rig.moving()
    at, sent = rig.motion.q[0], rig.motion
    rig.command(JointMotion(sent.q + change, sent.dq, sent.ddq))
    assert rig.fault().code is FaultCode.LIMITS
    for _ in range(200):
        rig.command(rig.motion)
    assert rig.supervisor.settled
    assert_smooth(rig.robot)
    expected = stopping(sent, LIMITS, stop_time(sent, LIMITS)).q[0]
    assert rig.robot.read().q[0] == pytest.approx(expected, abs=1e-6)
    assert expected > at


@pytest.mark.parametrize("code", [FaultCode.EMERGENCY_STOP, FaultCode.ARM_POWER, FaultCode.ROBOT])
def test_a_fault_of_the_robot_is_mirrored_and_stays_when_the_robot_clears_it(rig: Supervised, code: FaultCode) -> None:
    rig.moving()
    rig.robot.trouble = RobotFault(code, "what the robot says", native="E42")
    rig.command()
    written = len(rig.robot.written)
    rig.robot.trouble = None
    rig.commands(100)
    assert rig.supervisor.fault == RobotFault(code, "what the robot says", native="E42")
    assert rig.robot.stops == 1
    assert len(rig.robot.written) == written
    rig.activate(rig.robot.read().q)
    rig.turn()
    assert rig.supervisor.fault is None


@pytest.mark.parametrize("call", ["read", "write"])
@pytest.mark.parametrize(
    "error", [DriverError("line cut"), KeyError("oops"), ValueError("no"), SystemExit("bye"), KeyboardInterrupt("x")]
)
def test_a_driver_that_raises_is_stopped_and_named(rig: Supervised, error: BaseException, call: str) -> None:
    rig.moving()
    rig.robot.raises = {call: error}
    rig.command()
    assert rig.fault().code is FaultCode.DRIVER
    assert str(error) in rig.fault().sentence
    assert rig.robot.stops == 1


class UnspeakableError(Exception):
    """An error of a driver whose text raises, too."""

    def __str__(self) -> str:
        raise ValueError


def test_a_driver_whose_error_has_no_text_is_stopped_and_named(rig: Supervised) -> None:
    rig.moving()
    rig.robot.raises = {"read": UnspeakableError()}
    rig.command()
    assert rig.fault().code is FaultCode.DRIVER
    assert "read raised UnspeakableError: (its text cannot be read)" in rig.fault().sentence
    assert rig.robot.stops == 1


@pytest.mark.parametrize(("returned", "named"), [(None, "NoneType"), ("sent", "str")])
def test_a_driver_that_does_not_return_what_it_sent_is_stopped_and_named(
    rig: Supervised, monkeypatch: pytest.MonkeyPatch, returned: object, named: str
) -> None:
    rig.moving()
    monkeypatch.setattr(rig.robot, "write", lambda _command: returned)
    rig.command()
    assert rig.fault().code is FaultCode.DRIVER
    assert f"write returned {named}, not the JointCommand" in rig.fault().sentence
    assert rig.robot.stops == 1


def test_a_call_beyond_the_deadline_is_a_fault_and_visible_while_it_lasts(rig: Supervised) -> None:
    rig.moving()
    assert rig.mark.seen[-1] == 0
    assert max(rig.mark.seen) > 0
    rig.robot.slow_ms = 60
    rig.turn()
    assert rig.fault().code is FaultCode.DEADLINE
    assert "60 ms (limit 50 ms)" in rig.fault().sentence


def test_the_first_fault_is_kept(rig: Supervised) -> None:
    rig.moving()
    rig.command(JointMotion(rig.motion.q + 0.5, rig.motion.dq, rig.motion.ddq))
    rig.robot.trouble = RobotFault(FaultCode.EMERGENCY_STOP, "pressed")
    rig.turn()
    assert rig.fault().code is FaultCode.LIMITS
    assert rig.supervisor.state is SupervisorState.IDLE
    assert rig.robot.stops == 1


def test_a_driver_that_does_not_stop_either_is_named(rig: Supervised) -> None:
    rig.moving()
    rig.robot.raises = {"write": DriverError("line cut"), "stop": DriverError("no answer")}
    rig.command()
    assert rig.fault().sentence == "line cut; nor does it stop: no answer"
