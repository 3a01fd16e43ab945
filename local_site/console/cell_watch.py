"""Keeps the clock offset and the cell's description for the console, in a thread."""

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
ROUNDS_TO_DOUBT = 10  # of silence, until it probes for the reason


class CellWatch:
    """Measures the remote clock five times a second while its block lasts; asks for a description after each silence.

    `described` gets the description, `refused` the sentence of a cell of another release; both in the thread.
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
        logged = ""
        while not self._stop.wait(EVERY_S):
            try:
                self._measure()
            except RefusedError as error:
                if logged != str(error):
                    logged = str(error)
                    structlog.get_logger().error("the cell is refused", reason=logged)
                    self._refused(logged)

    def _measure(self) -> None:
        trip = self.clock.measure()
        self.round_trip_ms = None if trip is None else trip.duration_ns / NS_PER_MS
        if trip is None:
            self._known = None
            if self.clock.silent_rounds % ROUNDS_TO_DOUBT == 0 and (
                why := self._link.why_no_quic() or self._link.why_silent()
            ):
                raise RefusedError(why)
        elif self._known is None:
            self._known = self._link.ask(DESCRIBE, self._cell, DescribeQuestion())
            if self._known is not None:
                self._described(self._known)
