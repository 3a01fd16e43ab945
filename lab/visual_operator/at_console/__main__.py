"""Does the placing task once at a console's page: python -m lab.visual_operator.at_console SETUP (in JSON)."""

import os
import sys
import time
from contextlib import closing, suppress
from pathlib import Path

import msgspec

from common.atomic_file import write_atomically
from common.clock import NS_PER_MS, NS_PER_S
from common.errors import FarhandError, ProcessError
from common.messages.hand import Locks
from lab.visual_operator.at_console.console_page import ConsolePage
from lab.visual_operator.at_console.filmed_hand import FilmedHand
from lab.visual_operator.at_console.operator_process import OperatorSetup, TrialNotes
from lab.visual_operator.at_console.page_connection import PageConnection
from lab.visual_operator.at_console.sight_process import SightProcess
from lab.visual_operator.hand import Motor
from lab.visual_operator.operator import See, VisualOperator
from lab.visual_operator.task import PlacingTask

POLL_S = 0.02
FIFO_PRIORITY = 19  # below tracking


def do_task(setup: OperatorSetup) -> TrialNotes:
    """Wait until the page has everything, do the task, and leave; ProcessError when page or patience end."""
    task = PlacingTask()
    with closing(SightProcess(task)) as sight:
        _ask_for_real_time()
        with PageConnection(setup.port, setup.led_by, ConsolePage()) as connection:
            _wait(connection, setup.patience_s)
            return _operate(setup, connection, task, sight.see)


def _ask_for_real_time() -> None:
    """A hand and a page elsewhere wait for none of this machine's processors; where that is refused, these do."""
    with suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(FIFO_PRIORITY))


def _wait(connection: PageConnection, patience_s: float) -> None:
    deadline = time.monotonic() + patience_s
    while lacks := connection.page.lacks():
        if connection.is_over or time.monotonic() > deadline:
            raise ProcessError(f"the page still lacks {lacks}; see what the sites and the console warn of")
        time.sleep(POLL_S)


def _operate(setup: OperatorSetup, connection: PageConnection, task: PlacingTask, see: See) -> TrialNotes:
    page, start_ns = connection.page, time.monotonic_ns()
    if page.cell is None:
        raise ProcessError("the page has lost the cell's description")
    hand = FilmedHand(Motor(), setup.seed, start_ns)
    connection.hand = hand.take
    locks, mapping = Locks(roll=setup.roll_fixed), page.cell.mapping
    operator = VisualOperator(task, see, mapping, hand, locks)
    notes, due_ns = TrialNotes(start_ns=start_ns), start_ns
    while not operator.done and due_ns - start_ns < setup.most_s * NS_PER_S:
        now_ns = _sleep_until(due_ns)
        if connection.is_over:
            raise ProcessError("the console has closed the page; see its own log for why")
        if (shown := page.shown(now_ns)) is not None:
            operator.look(shown, start_ns)
            connection.intent = operator.intent
            oldest_ns = min(view.capture_ns for view in shown.views.values())
            took_ns = time.monotonic_ns() - now_ns
            notes.add_look((now_ns - oldest_ns) / NS_PER_MS, took_ns / NS_PER_MS, shown.code)
        due_ns += setup.page_ns * max(1, -(-(time.monotonic_ns() - due_ns) // setup.page_ns))
    return notes.end(operator.notes, time.monotonic_ns(), hand.late)


def _sleep_until(due_ns: int) -> int:
    time.sleep(max(0, due_ns - time.monotonic_ns()) / NS_PER_S)
    return time.monotonic_ns()


def main() -> None:
    """Do the task and write the notes of it."""
    setup = msgspec.json.decode(sys.argv[1], type=OperatorSetup)
    try:
        notes = do_task(setup)
    except FarhandError as error:
        sys.exit(f"farhand: {error}")
    write_atomically(Path(setup.notes), msgspec.json.encode(notes))


if __name__ == "__main__":
    main()
