"""Neighbours that ask and do not read the answers delay nobody else."""

import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from common.link.channels import LOAD_ECHO
from common.link.transport import open_link
from common.messages.probe import MOST_PADDING, ProbeEcho
from common.messages.requests import EngagementAction
from lab.stage.processes import module_command
from lab.stage.waiting import until
from tests.common.link.secured_cell import ANNA, BEN, CELL, Cell, reply_to, running, secured

ECHO = ProbeEcho(session=1, seq=0, sent_ns=0, received_ns=0, answered_ns=0, received=1, padding=bytes(MOST_PADDING))
MORE_THAN_BUFFERS_HOLD = 400  # echoes, 6.4 MB; Linux keeps 4 MB of what is to be sent
AT_ONCE_S = 2.0  # a busy machine's; who waits for one that does not read waits for 5 s


@contextmanager
def deaf(cell: Cell, folder: Path, *, sessions: int, every_s: float) -> Iterator[None]:
    """Ben's sessions, with links that can take nothing more, go on asking."""
    command = module_command("tests.common.link.deaf_neighbour", cell.endpoint, folder, every_s)
    filling = cell.link.publisher(LOAD_ECHO, CELL, operator=BEN)
    with ExitStack() as stack:
        for _ in range(sessions):
            asking = stack.enter_context(subprocess.Popen(command, stdout=subprocess.PIPE))
            stack.callback(asking.kill)
            assert asking.stdout is not None
            assert asking.stdout.readline()
        until(lambda: filling.has_listener)
        for _ in range(MORE_THAN_BUFFERS_HOLD):
            filling.put(ECHO)
            time.sleep(0.003)
        yield


@pytest.mark.slow
def test_neighbours_that_ask_and_never_read_keep_no_stop_out(pki: Path) -> None:
    with (
        running(secured(pki, "remote")) as cell,
        open_link(connect=(cell.endpoint,), security=secured(pki, f"operator.{ANNA}")) as anna,
    ):
        assert reply_to(anna, EngagementAction.STOP).done
        with deaf(cell, pki, sessions=4, every_s=0.002):  # more than Zenoh has threads that receive
            for _ in range(10):
                asked_s = time.monotonic()
                assert reply_to(anna, EngagementAction.STOP).done
                assert time.monotonic() - asked_s < AT_ONCE_S
                time.sleep(0.2)


@pytest.mark.slow
def test_an_answer_that_a_link_cannot_take_is_dropped_and_nobody_waits(pki: Path) -> None:
    with running(secured(pki, "remote")) as cell, deaf(cell, pki, sessions=1, every_s=0.05):
        asked = cell.asked
        until(lambda: cell.asked > asked + 10)
        assert cell.link._session.info.links()  # of one for whom it had waited it would have none
