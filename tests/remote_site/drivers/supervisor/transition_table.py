"""The rows of the supervisor's transition table, and a supervisor in each of its states."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from remote_site.drivers.driver import RobotReading
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.drivers.supervisor.orders import DriverOrder
from remote_site.drivers.supervisor.state import ACTIVE, DRIVEN, INACTIVE, SupervisorState
from tests.remote_site.drivers.supervisor.supervised import Supervised

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


def to_nan(reading: RobotReading) -> RobotReading:
    return replace(reading, q=reading.q * np.nan)


def old_order(rig: Supervised) -> DriverOrder:
    """A command that was planned before the last stop began."""
    order = rig.order(rig.plan())
    return replace(order, stop_count=order.stop_count - 1)
