"""What the robot reports latches the session; its end alone lets nothing move."""

import pytest
from remote_loop import RemoteLoop

from common.messages import SessionState
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.fault_latch import FaultLatch

PRESSED = RobotFault(FaultCode.EMERGENCY_STOP, "the emergency stop is pressed", native="E1")
START_M = (0.0, 0.0, 0.3)


@pytest.fixture
def engaged():
    loop = RemoteLoop()
    loop.run(300, lambda t_ns: START_M)  # noqa: ARG005
    assert loop.session.state is SessionState.ENGAGED
    return loop


def test_an_emergency_stop_latches_and_its_release_moves_nothing(engaged):
    latch = FaultLatch(engaged.session)
    latch.note(PRESSED)
    assert engaged.session.state is SessionState.FAULT
    latch.note(None)
    engaged.run(300, lambda t_ns: (0.1, 0.0, 0.3))  # noqa: ARG005
    assert engaged.session.state is SessionState.FAULT
    answer = engaged.session.request_engage(engaged.clock.now_ns(), engaged.robot)
    assert not answer.done
    assert "emergency_stop (E1): the emergency stop is pressed" in answer.reason.sentence
    engaged.session.reset()
    engaged.run(300, lambda t_ns: START_M)  # noqa: ARG005
    assert engaged.session.state is SessionState.DISENGAGED  # the reset alone does not engage
    assert engaged.session.request_engage(engaged.clock.now_ns(), engaged.robot).done
    engaged.run(10, lambda t_ns: START_M)  # noqa: ARG005
    assert engaged.session.state is SessionState.ENGAGED


def test_a_fault_that_lasts_is_told_once_and_can_be_reset(engaged):
    latch = FaultLatch(engaged.session)
    latch.note(PRESSED)
    engaged.session.reset()
    latch.note(PRESSED)
    assert engaged.session.state is SessionState.DISENGAGED
    latch.note(RobotFault(FaultCode.ARM_POWER, "no power"))
    assert engaged.session.state is SessionState.FAULT


@pytest.mark.parametrize("fault", [NOT_ACTIVATED, STOPPED, None])
def test_waiting_for_activation_is_no_fault(engaged, fault):
    FaultLatch(engaged.session).note(fault)
    assert engaged.session.state is SessionState.ENGAGED
