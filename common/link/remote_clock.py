"""The remote site's clock, as one link measures it."""

import threading
import time

from common.clock import ClockEstimate, OffsetEstimator, RoundTrip
from common.link.channels import CLOCK
from common.link.transport import Link
from common.messages.requests import ClockQuestion

EARLY_ROUNDS = (8, 17)  # of five a second: just before and beyond the patience with a site that has just started


class RemoteClock:
    """Measures the offset of the remote site's clock whenever asked to; may be read from any thread.

    After every `rounds_to_doubt` rounds of silence it probes for the reason, never with 0; earlier too in the first
    silence, when nobody has answered yet.
    """

    def __init__(self, link: Link, cell: str, rounds_to_doubt: int = 0) -> None:
        self._link, self._cell, self._rounds_to_doubt = link, cell, rounds_to_doubt
        self._estimator = OffsetEstimator()
        self._lock = threading.Lock()
        self.silent_rounds = 0
        self._was_answered = False

    def measure(self) -> RoundTrip | None:
        """One round trip, None without an answer in time; RefusedError where both sides refuse each other."""
        asked_ns = time.monotonic_ns()
        answer = self._link.ask(CLOCK, self._cell, ClockQuestion())
        if answer is None:
            self.silent_rounds += 1
            if self._doubts():
                self._link.check_connected()
            return None
        trip = RoundTrip(asked_ns, answer.received_ns, answer.answered_ns, time.monotonic_ns())
        self.silent_rounds, self._was_answered = 0, True
        with self._lock:
            self._estimator.add(trip)
        return trip

    def _doubts(self) -> bool:
        """Whether this round of silence is one to ask for its reason."""
        every, rounds = self._rounds_to_doubt, self.silent_rounds
        return every > 0 and (rounds % every == 0 or (not self._was_answered and rounds in EARLY_ROUNDS))

    def estimate(self, now_ns: int) -> ClockEstimate | None:
        """The remote clock minus ours; None without a round trip in the last four seconds."""
        with self._lock:
            return self._estimator.estimate(now_ns)
