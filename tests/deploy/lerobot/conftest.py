"""The package as LeRobot would find it, beside what stands in for LeRobot; and a cell that answers it."""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import msgspec
import pytest

import tests.common.messages.golden_examples as golden
from common.link.channels import CLOCK, DESCRIBE, OWN_CLOCK, OWN_DESCRIBE, STATE
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.transport import Link, open_link
from common.messages.requests import ClockAnswer, ClockQuestion
from common.messages.robot import RobotState
from farhand.certificates.folder import CertificateOrder, create
from tests.common.link.secured_cell import free_port, secured
from tests.common.link.watched_cell import watched

PACKAGE = Path(__file__).parents[3] / "deploy/lerobot"
for folder in (PACKAGE, Path(__file__).parent / "stand_in"):
    sys.path.insert(0, str(folder))

CELL, ANNA = golden.DESCRIPTION.cell, "anna"
OF_JOINTS = tuple(0.25 * (k + 1) for k in range(len(golden.DESCRIPTION.joints)))
CELL_STATE = msgspec.structs.replace(golden.STATE, q=OF_JOINTS, q_commanded=OF_JOINTS)
CLOCK_AHEAD_NS = 5_000 * 10**9  # of the cell's clock


class PublishedCell:
    """A remote site's link: publishes `state` as of now, less `late_ns`, and answers for description and clock."""

    def __init__(self, endpoint: str, link: Link) -> None:
        self.endpoint, self.control, self._link = endpoint, endpoint, link
        self.state: RobotState | None = CELL_STATE
        self.late_ns = 0
        self.tells_time = True
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        state = self._link.publisher(STATE, CELL)
        described = [self._link.answer(DESCRIBE, CELL, print)]
        described.append(self._link.answer(OWN_DESCRIBE, CELL, print, operator=ANNA))
        clocks = [self._link.answer(CLOCK, CELL, print), self._link.answer(OWN_CLOCK, CELL, print, operator=ANNA)]
        while not self._stop.wait(0.005):
            now_ns = time.monotonic_ns() + CLOCK_AHEAD_NS
            if self.state is not None:
                state.put(msgspec.structs.replace(self.state, t_ns=now_ns - self.late_ns))
            for asked in described:
                asked.poll(lambda _: golden.DESCRIPTION)
            for clock in clocks if self.tells_time else ():
                clock.poll(partial(_time, now_ns))

    def close(self) -> None:
        """End."""
        self._stop.set()
        self._thread.join()


def _time(now_ns: int, _asked: ClockQuestion) -> ClockAnswer:
    return ClockAnswer(received_ns=now_ns, answered_ns=now_ns)


@contextmanager
def running(protocol: str, security: LinkSecurity = ON_THIS_HOST) -> Iterator[PublishedCell]:
    """A cell on this host."""
    endpoint = f"{protocol}/127.0.0.1:{free_port()}"
    with open_link(listen=(endpoint,), security=security, operators=(ANNA,)) as link:
        cell = PublishedCell(endpoint, link)
        try:
            yield cell
        finally:
            cell.close()


@pytest.fixture
def published() -> Iterator[PublishedCell]:
    """A cell without certificates."""
    with running("tcp") as cell:
        yield cell


@pytest.fixture
def secured_cell(tmp_path: Path) -> Iterator[PublishedCell]:
    """A cell with certificates of its own authorities, in `pki`, as viewers see it."""
    create(tmp_path / "pki", CertificateOrder(CELL, (), 30, (ANNA,)), datetime.now(UTC))
    with (
        running("tls", secured(tmp_path / "pki", "remote", CELL)) as cell,
        watched(tmp_path / "pki", (cell.endpoint,), cell=CELL) as endpoint,
    ):
        cell.endpoint = endpoint
        yield cell
