"""Every row of the supervisor's transition table, in every state that it names; and no transition beside the table."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from random import Random

import numpy as np
import pytest

from common.errors import DriverError
from remote_site.drivers.driver import RobotReading
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.drivers.supervisor.orders import DriverOrder
from remote_site.drivers.supervisor.state import ACTIVE, DRIVEN, INACTIVE, SupervisorState
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.kinematics.joints import JointMotion
from tests.remote_site.drivers.supervisor.supervised import START, Supervised

SETS = {"INACTIVE": INACTIVE, "ACTIVE": ACTIVE, "DRIVEN": DRIVEN, **{state.name: {state} for state in SupervisorState}}
PRESSED = RobotFault(FaultCode.EMERGENCY_STOP, "pressed")


@dataclass(frozen=True)
class Row:
    """A row of the table: its name, the states it begins in, the state it ends in, None for the same."""

    name: str
    states: frozenset[SupervisorState]
    next: SupervisorState | None


def table() -> Iterator[Row]:
    """The rows as the docstring prints them."""
    _, _, body, _ = re.split(r"^ *=+ [= ]+$", SupervisorState.__doc__ or "", flags=re.MULTILINE)
    for line in body.strip().splitlines():
        name, states, _, following, _ = re.split(r"  +", line.strip())
        begin = frozenset().union(*(SETS[each] for each in states.split(", ")))
        yield Row(name, begin, None if following == "same" else SupervisorState[following])


ROWS = list(table())
CASES = [(row, state) for row in ROWS for state in sorted(row.states, key=lambda state: state.name)]


def reach(state: SupervisorState) -> Supervised:
    """A supervisor in a state; where it is driven, in motion."""
    rig = Supervised()
    if state is SupervisorState.ACTIVATING:
        rig.robot.trouble = NOT_ACTIVATED
        rig.activate()
    elif state is SupervisorState.HELD:
        rig.activate()
        rig.command(rig.sent)
        rig.turn(rig.order(rig.sent, run=False))
    elif state in DRIVEN:
        rig.moving()
    if state is SupervisorState.BRAKING:
        rig.stumble(14)
    elif state is SupervisorState.STOPPING:
        rig.supervisor.stop(STOPPED, rig.clock.now_ns())
    assert rig.supervisor.state is state
    return rig


def old_order(rig: Supervised) -> DriverOrder:
    """A command that was planned before the last stop began."""
    order = rig.order(rig.plan())
    return replace(order, stop_count=order.stop_count - 1)


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
    rig.supervisor.reading = RobotReading(0, START, np.full(6, 0.03), None, None, None)
    rig.supervisor.take([rig.order(rig.sent)], rig.clock.now_ns())
    assert rig.fault().code is FaultCode.REFUSED
    assert rig.robot.stops == stops


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
        rig.turn()  # the robot has nothing to read before it is activated
        assert rig.fault() is calm
    rig.robot.raises = {"read": KeyError("oops")}
    rig.turn()
    assert rig.fault().code is FaultCode.DRIVER
    assert rig.robot.stops == stops


EVENTS: dict[str, Callable[[Supervised], None]] = {
    event.__name__: event
    for event in (
        activate, rejected, arm_moves, too_early, answered, apart, refused, waits, command, over_limit, outdated,
        hand_over, missed, stop_order, late, late_rest, silent, stopped, robot_fault, call_fails, read_fails,
    )
}  # fmt: skip


@pytest.mark.parametrize(("row", "state"), CASES, ids=[f"{row.name}-{state.name}" for row, state in CASES])
def test_every_row_of_the_table_is_what_the_supervisor_does(row: Row, state: SupervisorState) -> None:
    rig = reach(state)
    EVENTS[row.name](rig)
    assert rig.supervisor.state is (row.next or state)


def test_the_table_has_every_event_that_is_tried() -> None:
    assert [row.name for row in ROWS] == list(EVENTS)


def test_chance_finds_no_transition_beside_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[SupervisorState] = []

    def note(supervisor: DriverSupervisor, name: str, value: object) -> None:
        if name == "state":
            assert isinstance(value, SupervisorState)
            seen.append(value)
        object.__setattr__(supervisor, name, value)

    monkeypatch.setattr(DriverSupervisor, "__setattr__", note)
    listed = {(state, row.next or state) for row, state in CASES}
    found = set()
    for seed in range(40):
        seen.clear()
        wander(Supervised(), Random(seed))  # noqa: S311
        found |= set(pairwise(seen))
    changes = {(one, other) for one, other in found if one is not other}
    assert changes <= listed
    assert len(changes) > 10


def wander(rig: Supervised, rng: Random) -> None:
    """Ninety turns of commands, silence, faults and activations at random."""
    for _ in range(90):
        event = rng.random()
        rig.robot.trouble = PRESSED if event < 0.01 else None
        call = rng.choice(["activate", "read", "write", "stop"])
        rig.robot.raises = {call: KeyError("oops")} if event > 0.98 else {}
        if rig.supervisor.state in INACTIVE or event < 0.03:
            rig.robot.trouble = rng.choice([None, None, NOT_ACTIVATED])
            rig.activate(START if rig.supervisor.reading is None else rig.supervisor.reading.q)
        elif event < 0.2:
            rig.stumble(rng.uniform(2, 60))
        elif event < 0.25:
            rig.turn(rig.order(rig.sent, run=event > 0.22))
        elif rig.supervisor.commanded.stop is not None:
            rig.sent = rig.stop_at()
            rig.turn(rig.order(rig.sent), ms=0)
        else:
            rig.command()
