"""Whether the hand samples may be followed: their age, how many came in a row, what is wrong with them; pure."""

from common.clock import NS_PER_MS
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.samples import Accepted, Rejected

REPEATS = (Code.DUPLICATE, Code.OLD)  # they do not concern the hand
CLOCK_TROUBLE = (Code.NO_OFFSET, Code.OLD_OFFSET, Code.FUTURE)  # the age of the hand is unknown


class HandSignal:
    """Judged samples as one signal; `good` counts those accepted in a row without a gap beyond T_soft."""

    def __init__(self, safety: SafetyConfig) -> None:
        self.soft_ns = round(safety.t_soft_ms * NS_PER_MS)
        self._latch_ns = round(safety.t_latch_ms * NS_PER_MS)
        self.good = 0
        self._born_ns: int | None = None
        self._trouble: Reason | None = None

    def restart(self) -> None:
        """Reset the count, as for a new local session."""
        self.good, self._born_ns = 0, None

    def forget(self) -> None:
        """Reset the count, and drop what was wrong before, as for a new lease."""
        self.restart()
        self._trouble = None

    def take(self, result: Accepted | Rejected) -> None:
        """Take note of a judged sample."""
        if isinstance(result, Accepted):
            gap_ns = result.born_ns - self._born_ns if self._born_ns is not None else 0
            self.good = self.good + 1 if gap_ns <= self.soft_ns else 1
            self._born_ns, self._trouble = result.born_ns, None
        elif result.reason.code not in REPEATS:
            self.good = 0
            if result.hand_lost or result.reason.code in CLOCK_TROUBLE:
                self._trouble = result.reason

    def too_old(self, now_ns: int) -> Reason | None:
        """Why the engagement must end, None while the newest good sample is younger than T_latch."""
        if self._age_ns(now_ns) <= self._latch_ns:
            return None
        return self._trouble or self._stale(now_ns, self._latch_ns)

    def unfit(self, now_ns: int) -> Reason | None:
        """Why the newest hand sample must not be followed now."""
        if self._trouble is not None:
            return self._trouble
        if self._born_ns is None:
            return reason(Code.NO_HAND)
        return self._stale(now_ns, self.soft_ns) if self._age_ns(now_ns) > self.soft_ns else None

    def collecting(self, needed: int) -> Reason | None:
        """How many good samples are still missing, None if enough have come in a row."""
        return reason(Code.COLLECTING, count=min(self.good, needed), needed=needed) if self.good < needed else None

    def _age_ns(self, now_ns: int) -> int:
        return now_ns - self._born_ns if self._born_ns is not None else self._latch_ns + 1

    def _stale(self, now_ns: int, limit_ns: int) -> Reason:
        return reason(Code.STALE, age_ms=self._age_ns(now_ns) / NS_PER_MS, limit_ms=limit_ns / NS_PER_MS)
