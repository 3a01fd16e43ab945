"""The console's acquaintance with the cell, kept in a thread of its own: the clocks' offset, and what the cell is."""

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

import structlog

from common.clock import NS_PER_MS, ClockEstimate
from common.errors import RefusedError
from common.link.channels import DESCRIBE
from common.link.remote_clock import RemoteClock
from common.link.transport import Link
from common.messages.requests import DescribeQuestion, Description

EVERY_S = 0.2
ROUNDS_TO_DOUBT = 10  # of silence, until the reason is looked for


class CellWatch:
    """Asks the remote site's clock five times a second as long as the block lasts, and what it is after each silence.

    `described` hears the description, `refused` the sentence of a cell of another release; both in the thread.
    """

    def __init__(
        self, link: Link, cell: str, described: Callable[[Description], None], refused: Callable[[str], None]
    ) -> None:
        self._link, self._cell = link, cell
        self._described, self._refused = described, refused
        self.clock = RemoteClock(link, cell, ROUNDS_TO_DOUBT)
        self._known: Description | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="cell", daemon=True)
        self.round_trip_ms: float | None = None

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()

    def estimate(self, now_ns: int) -> ClockEstimate | None:
        """The remote clock minus ours; None while it is not known."""
        return self.clock.estimate(now_ns)

    def _run(self) -> None:
        told = ""
        while not self._stop.wait(EVERY_S):
            try:
                self._look()
            except RefusedError as error:
                if told != str(error):
                    told = str(error)
                    structlog.get_logger().error("the cell is refused", reason=told)
                    self._refused(told)

    def _look(self) -> None:
        trip = self.clock.measure()
        self.round_trip_ms = None if trip is None else trip.duration_ns / NS_PER_MS
        if trip is None:
            self._known = None
        elif self._known is None:
            self._known = self._link.ask(DESCRIBE, self._cell, DescribeQuestion())
            if self._known is not None:
                self._described(self._known)
