"""Activation: only at rest, only where the arm is, and refused while the robot has a fault."""

from dataclasses import replace

import pytest

from common.errors import DriverError
from remote_site.drivers.faults import STOPPED, FaultCode, RobotFault
from remote_site.drivers.supervisor.state import ACTIVE, INACTIVE, SupervisorState
from tests.remote_site.drivers.supervisor.supervised import START, Supervised


def test_activation_waits_for_rest(rig: Supervised) -> None:
    rig.moving()
    rig.activate(rig.motion.q)
    assert rig.fault().code is FaultCode.REFUSED
    assert rig.robot.stops == 0  # it is led to rest
    rig.turns(200)
    assert rig.supervisor.settled
    rig.activate(rig.motion.q)
    rig.turn()
    assert rig.supervisor.state is SupervisorState.FOLLOWING
    assert rig.supervisor.fault is None


def test_an_activation_of_an_active_robot_at_rest_stops_it(rig: Supervised) -> None:
    rig.activate()
    rig.command(rig.sent)
    activations = rig.robot.activations
    rig.activate()
    assert rig.fault().code is FaultCode.REFUSED
    assert rig.supervisor.state not in ACTIVE
    assert rig.robot.activations == activations


def test_a_robot_that_refuses_to_be_activated_is_stopped_and_can_be_asked_again(rig: Supervised) -> None:
    rig.robot.raises = {"activate": DriverError("not now")}
    rig.activate()
    rig.robot.raises.clear()
    assert rig.fault().code is FaultCode.REFUSED
    assert rig.robot.stops == 1
    rig.activate()
    rig.turn()
    assert rig.supervisor.state is SupervisorState.FOLLOWING


def test_an_arm_that_is_elsewhere_is_not_activated(rig: Supervised) -> None:
    rig.activate()
    rig.supervisor.stop(STOPPED, rig.clock.now_ns())
    rig.turns(10)
    rig.robot.off_rad = 0.2
    rig.activate(START)
    assert rig.fault().code is FaultCode.APART


def test_an_activation_fails_while_the_robots_fault_lasts(rig: Supervised) -> None:
    rig.moving()
    rig.robot.trouble = RobotFault(FaultCode.EMERGENCY_STOP, "pressed")
    rig.commands(100)
    rig.activate(rig.robot.read().q)
    rig.turn()
    assert rig.fault().code is FaultCode.EMERGENCY_STOP
    assert rig.supervisor.state in INACTIVE


def test_an_arm_is_not_activated_at_what_is_no_position(rig: Supervised) -> None:
    activations = rig.robot.activations
    rig.activate(START * float("nan"))
    assert rig.fault().code is FaultCode.APART
    assert rig.robot.activations == activations


def test_an_arm_whose_encoders_were_set_anew_is_activated_where_it_is_once_it_could_have_got_there(
    rig: Supervised,
) -> None:
    rig.turns(10)
    anew = START + 0.5
    rig.robot.spoil = lambda reading: replace(reading, q=reading.q + 0.5)
    rig.robot.off_rad = -0.5
    rig.turn()
    assert rig.fault().code is FaultCode.IMPLAUSIBLE
    rig.activate(anew)
    assert rig.fault().code is FaultCode.IMPLAUSIBLE
    assert rig.robot.activations == 0
    rig.turns(150)
    assert rig.supervisor.reading is not None
    assert rig.supervisor.reading.q == pytest.approx(anew)
    rig.activate(anew)
    rig.turn()
    assert rig.supervisor.fault is None
    assert rig.supervisor.state is SupervisorState.FOLLOWING
