"""What happens to a pair of sites in a fault: to the hand and its cameras, the robot, the link, a process."""

import os
import signal
from collections.abc import Callable
from typing import Any

from tests.faults.cell_pair import CellPair
from tests.integration.sites import child_of

Act = Callable[[CellPair], object]


def hand(**fields: Any) -> Act:
    """Command the scripted hand or its cameras."""
    return lambda pair: pair.hand(**fields)


def robot(**fields: Any) -> Act:
    """Command the recording driver."""
    return lambda pair: pair.robot(**fields)


def impair(**fields: Any) -> Act:
    """Impair the link between the hosts; without fields it is a good one again."""
    return lambda pair: pair.impair(**fields)


def jumps(count: int) -> Act:
    """Show the wrist a metre off in `count` frames."""
    return hand(jump_m=(0.0, 0.7, 0.7), jumps=count)


def kill_local(pair: CellPair) -> None:
    """Kill the local site immediately."""
    os.kill(pair.local.pid, signal.SIGKILL)


def control_gets(number: signal.Signals) -> Act:
    """Send the control process a signal."""
    return lambda pair: os.kill(child_of(pair.remote, "farhand-control"), number)
