"""The remote site's clock, as one link measures it."""

import threading
import time

from common.clock import ClockEstimate, OffsetEstimator, RoundTrip
from common.link.channels import CLOCK
from common.link.transport import Link
from common.messages.requests import ClockQuestion


class RemoteClock:
    """Measures the offset of the remote site's clock whenever asked to; may be read from any thread.

    After every `rounds_to_doubt` rounds of silence it probes for the reason; never with 0.
    """

    def __init__(self, link: Link, cell: str, rounds_to_doubt: int = 0) -> None:
        self._link, self._cell, self._rounds_to_doubt = link, cell, rounds_to_doubt
        self._estimator = OffsetEstimator()
        self._lock = threading.Lock()
        self.silent_rounds = 0

    def measure(self) -> RoundTrip | None:
        """One round trip, None without an answer in time; RefusedError where both sides refuse each other."""
        asked_ns = time.monotonic_ns()
        answer = self._link.ask(CLOCK, self._cell, ClockQuestion())
        if answer is None:
            self.silent_rounds += 1
            if self._rounds_to_doubt and self.silent_rounds % self._rounds_to_doubt == 0:
                self._link.check_connected()
            return None
        trip = RoundTrip(asked_ns, answer.received_ns, answer.answered_ns, time.monotonic_ns())
        self.silent_rounds = 0
        with self._lock:
            self._estimator.add(trip)
        return trip

    def estimate(self, now_ns: int) -> ClockEstimate | None:
        """The remote clock minus ours; None without a round trip in the last four seconds."""
        with self._lock:
            return self._estimator.estimate(now_ns)
