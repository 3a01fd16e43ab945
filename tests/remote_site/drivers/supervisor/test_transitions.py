"""Every row of the supervisor's transition table, in every state that it names."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.errors import DriverError
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.drivers.supervisor.following_check import PATIENCE_NS
from remote_site.drivers.supervisor.state import DRIVEN, INACTIVE, SupervisorState
from remote_site.kinematics.joints import JointMotion
from tests.remote_site.drivers.supervisor.supervised import START, Supervised
from tests.remote_site.drivers.supervisor.transition_table import CASES, PRESSED, ROWS, Row, old_order, reach, to_nan
from tests.remote_site.spoiled_readings import drifting


def activate(rig: Supervised) -> None:
    rig.robot.trouble = NOT_ACTIVATED
    rig.activate()
    assert rig.fault() is NOT_ACTIVATED
    assert rig.motion.q == pytest.approx(START)


def rejected(rig: Supervised) -> None:
    rig.robot.raises = {"activate": DriverError("not now")}
    rig.activate()
    assert rig.fault() == RobotFault(FaultCode.REFUSED, "not now")
    assert rig.robot.stops > 0


def arm_moves(rig: Supervised) -> None:
    stops, rig.activation = rig.robot.stops, rig.activation + 1
    rig.robot.spoil = lambda reading: replace(reading, dq=np.full(6, 0.03))
    rig.supervisor.take([rig.order(rig.sent)], rig.clock.now_ns())
    assert rig.fault().code is FaultCode.REFUSED
    assert rig.robot.stops == stops


def unread(rig: Supervised) -> None:
    activations, rig.robot.spoil = rig.robot.activations, to_nan
    rig.activate()
    assert rig.fault().code is FaultCode.NOT_FINITE
    assert rig.robot.activations == activations


def elsewhere(rig: Supervised) -> None:
    activations = rig.robot.activations
    rig.activate(START + 0.06 * np.eye(6)[3])
    assert rig.fault().code is FaultCode.APART
    assert "joint_4 is at 0.000 rad, not 0.060 rad" in rig.fault().sentence
    assert rig.robot.activations == activations


def withdrawn(rig: Supervised) -> None:
    activations, rig.robot.spoil = rig.robot.activations, to_nan
    rig.activate()
    assert rig.fault().code is FaultCode.NOT_FINITE
    assert rig.robot.stops == 1
    assert rig.robot.activations == activations


def too_early(rig: Supervised) -> None:
    stop = rig.supervisor.commanded.stop
    rig.activate()
    assert rig.fault().code is FaultCode.REFUSED
    assert rig.supervisor.commanded.stop is not None
    assert stop is None or rig.supervisor.commanded.stop is stop


def answered(rig: Supervised) -> None:
    rig.robot.trouble = None
    rig.turn()
    assert rig.supervisor.fault is None


def apart(rig: Supervised) -> None:
    rig.robot.trouble = None
    rig.robot.activate(START + 0.06)
    rig.turn()
    assert rig.fault().code is FaultCode.APART
    assert rig.robot.stops == 1


def refused(rig: Supervised) -> None:
    rig.robot.trouble = PRESSED
    rig.turn()
    assert rig.fault() is PRESSED
    assert (rig.motion.q == START).all()


def waits(rig: Supervised) -> None:
    for _ in range(100):
        rig.turn(rig.order(rig.sent))
    assert rig.fault() is NOT_ACTIVATED
    assert not rig.robot.written


def command(rig: Supervised) -> None:
    rig.command()
    assert rig.robot.written[-1].q is rig.sent.q


def over_limit(rig: Supervised) -> None:
    rig.command(JointMotion(rig.motion.q + 0.01, rig.motion.dq, rig.motion.ddq))
    assert rig.fault().code is FaultCode.LIMITS
    assert rig.robot.written[-1].q is not rig.sent.q


def outdated(rig: Supervised) -> None:
    braking = rig.supervisor.state is SupervisorState.BRAKING
    for _ in range(40 if braking else 5):  # the time-out is 50 ms
        rig.turn(old_order(rig))
        assert rig.motion.q[0] != rig.plan().q[0]
    assert rig.supervisor.fault is None


def hand_over(rig: Supervised) -> None:
    sent = rig.stop_at()
    rig.turn(rig.order(sent), ms=0)
    assert rig.supervisor.commanded.stop is None
    assert rig.motion.q is sent.q


def missed(rig: Supervised) -> None:
    count, stop = rig.stop_count, rig.supervisor.commanded.stop
    rig.turn(rig.order(rig.stop_at(-8.0)), ms=0)
    assert rig.stop_count == count + 1
    assert rig.supervisor.commanded.stop is stop


def stop_order(rig: Supervised) -> None:
    rig.turn(rig.order(rig.sent, run=False))
    assert rig.fault() is STOPPED
    assert rig.robot.stops == 0


def late(rig: Supervised) -> None:
    last = rig.motion
    rig.turn(ms=12)
    assert rig.supervisor.state is SupervisorState.FOLLOWING
    rig.turn(ms=0.1)
    assert rig.stop_count == 1
    assert rig.supervisor.commanded.stop is not None
    assert rig.supervisor.commanded.stop.motion is last


def late_rest(rig: Supervised) -> None:
    while not rig.motion.resting:
        if rig.supervisor.state is SupervisorState.BRAKING:
            rig.turn(old_order(rig))
        else:
            rig.command()
    written, count = len(rig.robot.written), rig.stop_count
    rig.stumble(30)
    assert len(rig.robot.written) > written + 5
    assert rig.stop_count == count


def silent(rig: Supervised) -> None:
    rig.stumble(52)
    assert rig.fault().code is FaultCode.COMMAND_TIMEOUT
    assert rig.robot.stops == 0


def slow(rig: Supervised) -> None:
    """Turns of 60 ms, each with an order: neither control nor the robot is silent."""
    for _ in range(16):
        rig.turn(ms=2)
        assert rig.supervisor.state not in INACTIVE
    for took_ms in [60.0] * 16:
        assert rig.supervisor.state not in INACTIVE
        rig.turn(old_order(rig), ms=took_ms)
    assert rig.supervisor.state not in INACTIVE
    rig.turn(old_order(rig), ms=60.0)
    assert rig.fault().code is FaultCode.DEADLINE
    assert "the driver's process has not kept up for a second: a turn takes 60 ms (limit 50 ms)" in rig.fault().sentence
    assert rig.robot.stops == 1


def stopped(rig: Supervised) -> None:
    for _ in range(300):
        if rig.supervisor.state is not SupervisorState.STOPPING:
            break
        assert rig.robot.stops == 0
        rig.turn()
    assert rig.fault() is STOPPED
    assert rig.robot.stops == 1
    assert (rig.motion.q == rig.robot.written[-1].q).all()


def robot_fault(rig: Supervised) -> None:
    latched = rig.supervisor.fault
    rig.robot.trouble = PRESSED
    rig.turn()
    assert rig.fault() is PRESSED
    assert latched is None or latched.calm
    assert rig.robot.stops == 1


def bad_reading(rig: Supervised) -> None:
    written, latched = len(rig.robot.written), rig.supervisor.fault
    rig.robot.spoil = to_nan
    rig.turn()
    assert rig.fault().code is FaultCode.NOT_FINITE
    assert latched is None or latched.calm
    assert rig.robot.stops == 1
    rig.turns(50)
    assert len(rig.robot.written) <= written + 1  # a write comes before the reading of its turn
    assert rig.supervisor.reading is not None
    assert np.isfinite(rig.supervisor.reading.q).all()


def bad_at_rest(rig: Supervised) -> None:
    stops = rig.robot.stops
    rig.robot.spoil = to_nan
    rig.turn()
    assert rig.fault().code is FaultCode.NOT_FINITE
    assert rig.robot.stops == stops


def astray(rig: Supervised) -> None:
    latched = rig.supervisor.fault
    rig.robot.spoil = drifting(-0.5)
    begin_ns = rig.clock.now_ns()
    while rig.supervisor.state in DRIVEN:
        if rig.supervisor.state is SupervisorState.BRAKING:
            rig.turn(old_order(rig))
        elif rig.supervisor.state is SupervisorState.FOLLOWING:
            rig.command()
        else:
            rig.turn()
        assert rig.clock.now_ns() - begin_ns < 250 * NS_PER_MS
    assert rig.clock.now_ns() - begin_ns >= PATIENCE_NS
    assert rig.robot.stops == 1
    assert latched is None or latched.calm
    assert rig.fault().code is FaultCode.NOT_FOLLOWING


def call_fails(rig: Supervised) -> None:
    call = "read" if rig.supervisor.state is SupervisorState.ACTIVATING else "write"
    rig.robot.raises = {call: DriverError("line cut")}
    if rig.supervisor.state is SupervisorState.FOLLOWING:
        rig.command()
    else:
        rig.turn()
    assert rig.fault() == RobotFault(FaultCode.DRIVER, "line cut")
    assert rig.robot.stops == 1


def read_fails(rig: Supervised) -> None:
    calm, stops = rig.fault(), rig.robot.stops
    if rig.supervisor.reading is None:
        rig.robot.raises = {"read": DriverError("nothing measured yet")}
        rig.turn()
        assert rig.fault() is calm
    rig.robot.raises = {"read": KeyError("oops")}
    rig.turn()
    assert rig.fault().code is FaultCode.DRIVER
    assert rig.robot.stops == stops


EVENTS: dict[str, Callable[[Supervised], None]] = {
    event.__name__: event
    for event in (
        activate, rejected, arm_moves, unread, elsewhere, withdrawn, too_early, answered, apart, refused, waits,
        command, over_limit, outdated, hand_over, missed, stop_order, late, late_rest, silent, slow, stopped,
        robot_fault, bad_reading, bad_at_rest, astray, call_fails, read_fails,
    )
}  # fmt: skip


@pytest.mark.parametrize(("row", "state"), CASES, ids=[f"{row.name}-{state.name}" for row, state in CASES])
def test_every_row_of_the_table_is_what_the_supervisor_does(row: Row, state: SupervisorState) -> None:
    rig = reach(state)
    EVENTS[row.name](rig)
    assert rig.supervisor.state is (row.next or state)


def test_the_table_has_every_event_that_is_tried() -> None:
    assert [row.name for row in ROWS] == list(EVENTS)
