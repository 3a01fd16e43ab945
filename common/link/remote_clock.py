"""The remote site's clock, as one link measures it."""

import threading

from common.clock import ClockEstimate, RoundTrip
from common.host_clock import host_time
from common.link.aside import Aside
from common.link.channels import CLOCK
from common.link.transport import Link
from common.messages.requests import ClockQuestion
from common.steady_time import HostTime, SteadyEstimator

EARLY_ROUNDS = (8, 17)  # of five a second: just before and beyond the patience with a site that has just started


class RemoteClock:
    """Measures the offset of the remote site's clock whenever asked to; may be read from any thread.

    After every `rounds_to_doubt` rounds of silence it probes for the reason, never with 0; earlier too in the first
    silence, when nobody has answered yet. A probe takes seconds, so it is made aside, and a later round tells what it
    found, unless the site has answered meanwhile.
    """

    def __init__(self, link: Link, cell: str, rounds_to_doubt: int = 0) -> None:
        self._link, self._cell, self._rounds_to_doubt = link, cell, rounds_to_doubt
        self._estimator = SteadyEstimator()
        self._lock = threading.Lock()
        self.silent_rounds = 0
        self._was_answered = False
        self._probe = Aside("probe")

    def measure(self) -> RoundTrip | None:
        """Measure one round trip, None without an answer in time; RefusedError where both sides refuse each other."""
        self._probe.check()
        asked = host_time()
        answer = self._link.ask(CLOCK, self._cell, ClockQuestion())
        if answer is None:
            self.silent_rounds += 1
            if self._doubts():
                self._probe.start(self._link.check_connected)
            return None
        self._probe.forget()
        answered, reply = HostTime(answer.answered_ns, answer.ahead_ns), host_time()
        self.silent_rounds, self._was_answered = 0, True
        with self._lock:
            return self._estimator.add(asked, answer.received_ns, answered, reply)

    def _doubts(self) -> bool:
        """Return whether to ask for the reason in this round of silence."""
        every, rounds = self._rounds_to_doubt, self.silent_rounds
        return every > 0 and (rounds % every == 0 or (not self._was_answered and rounds in EARLY_ROUNDS))

    def estimate(self, now_ns: int, since_ns: int | None = None) -> ClockEstimate | None:
        """Estimate the remote clock minus ours; None without a round trip in the last four seconds.

        Without `since_ns` it is the offset of now. For a stamp that our clock gave at `since_ns`, it is of all offsets
        since then the one by which the stamp is oldest: it is never taken for younger than it is.
        """
        now = HostTime(now_ns, host_time().ahead_ns)
        with self._lock:
            return self._estimator.estimate(now, since_ns)
