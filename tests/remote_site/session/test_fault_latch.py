"""What the robot reports latches the session; its end alone lets nothing move."""

import pytest

from common.messages.robot import SessionState
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.session.fault_latch import FaultLatch
from tests.remote_site.remote_loop import RemoteLoop

PRESSED = RobotFault(FaultCode.EMERGENCY_STOP, "the emergency stop is pressed", native="E1")
MS = 1_000_000
START_M = (0.0, 0.0, 0.3)


@pytest.fixture
def engaged():
    loop = RemoteLoop()
    loop.run(300, lambda t_ns: START_M)  # noqa: ARG005
    assert loop.session.state is SessionState.ENGAGED
    return loop


def test_an_emergency_stop_latches_and_its_release_moves_nothing(engaged):
    latch = FaultLatch(engaged.session)
    latch.note(PRESSED, 0, resting=True)
    assert engaged.session.state is SessionState.FAULT
    latch.note(None, 0, resting=True)
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
    latch.note(PRESSED, 0, resting=True)
    engaged.session.reset()
    latch.note(PRESSED, 0, resting=True)
    assert engaged.session.state is SessionState.DISENGAGED
    latch.note(RobotFault(FaultCode.ARM_POWER, "no power"), 0, resting=True)
    assert engaged.session.state is SessionState.FAULT


def test_a_fault_that_an_activation_did_not_end_latches_again(engaged):
    latch = FaultLatch(engaged.session)
    latch.note(PRESSED, 0, resting=True)
    engaged.session.reset()
    latch.activated()
    latch.note(PRESSED, 0, resting=True)  # the driver's process was quick to refuse
    assert engaged.session.state is SessionState.FAULT


@pytest.mark.parametrize("fault", [NOT_ACTIVATED, STOPPED, None])
def test_waiting_for_activation_is_no_fault(engaged, fault):
    FaultLatch(engaged.session).note(fault, 0, resting=True)
    assert engaged.session.state is SessionState.ENGAGED


LATE = RobotFault(FaultCode.COMMAND_TIMEOUT, "no command for 102 ms")
STILL_MOVING = RobotFault(FaultCode.REFUSED, "the arm still moves; activate it when it rests")


@pytest.fixture
def waiting():
    return RemoteLoop().session


def test_a_stumble_of_control_at_rest_before_anybody_is_engaged_is_mended(waiting):
    latch = FaultLatch(waiting)
    faults = [None, LATE, STILL_MOVING, NOT_ACTIVATED, None]
    assert [latch.note(fault, 200 * MS * k, resting=True) for k, fault in enumerate(faults)] == [
        False,
        True,
        True,
        False,
        False,
    ]
    assert waiting.state is SessionState.DISENGAGED
    latch.note(STILL_MOVING, 2000 * MS, resting=True)
    assert waiting.state is SessionState.FAULT


def test_a_robot_that_refuses_is_asked_ten_times_a_second_and_not_in_every_tick(waiting):
    latch = FaultLatch(waiting)
    faults = [LATE] + [STILL_MOVING] * 99
    asked = [k for k, fault in enumerate(faults) if latch.note(fault, 4 * MS * k, resting=True)]
    assert asked == [0, 25, 50, 75]
    assert waiting.state is SessionState.DISENGAGED


def test_a_robot_silent_for_a_moment_before_anybody_is_engaged_is_waited_for(waiting):
    latch = FaultLatch(waiting)
    silent = RobotFault(FaultCode.SILENT, "no readings")
    assert [latch.note(fault, 0, resting=True) for fault in (silent, silent, None)] == [False, False, False]
    assert waiting.state is SessionState.DISENGAGED
    latch.note(silent, 0, resting=False)
    assert waiting.state is SessionState.FAULT


@pytest.mark.parametrize("worse", [PRESSED, RobotFault(FaultCode.APART, "the arm is not where it was activated")])
def test_what_is_wrong_with_the_robot_itself_is_never_mended(waiting, worse):
    latch = FaultLatch(waiting)
    assert latch.note(LATE, 0, resting=True)
    assert not latch.note(worse, 0, resting=True)
    assert waiting.state is SessionState.FAULT


def test_a_stumble_that_ended_a_motion_stays_a_fault(engaged, waiting):
    for session, resting in ((engaged.session, True), (waiting, False)):
        assert not FaultLatch(session).note(LATE, 0, resting=resting)
        assert session.state is SessionState.FAULT


def test_a_drivers_process_that_paused_at_rest_goes_on_without_an_activation(waiting):
    latch = FaultLatch(waiting)
    silent = RobotFault(FaultCode.PROCESS, "the driver's process is silent for 101 ms")
    assert [latch.note(fault, 0, resting=True) for fault in (silent, None)] == [False, False]
    assert waiting.state is SessionState.DISENGAGED
