"""Signal of the hand: whether its samples may be followed, by age, number in a row, and what else is wrong; pure."""

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.age_limit import AgeLimit
from remote_site.session.samples import Accepted, Rejected

AGAIN_FRAMES = 12  # once the link has been down: enough to judge how it is now (`link_ages.py`)
AGAIN_NS = 30 * NS_PER_S  # so long a window's ages count
ANSWERED_NS = 1500 * NS_PER_MS  # samples come by lanes too: only answers show that a stop would come through
REPEATS = (Code.DUPLICATE, Code.OLD)  # they do not concern the hand
CLOCK_TROUBLE = (Code.NO_OFFSET, Code.OLD_OFFSET, Code.FUTURE)  # the age of the hand is unknown


class HandSignal:
    """Judged samples as one signal; `good` counts those accepted in a row without a gap beyond T_soft.

    Once there were as many as an engagement needs, `engagement_frames`, fewer are enough after nothing but silence or
    late samples: hand and clock are as they were, the ages before the gap still count, and only how old the samples are
    now has to be seen.
    """

    def __init__(self, safety: SafetyConfig, limit: AgeLimit, engagement_frames: int) -> None:
        self._limit = limit
        self._engagement_frames = engagement_frames
        self._proven_ns: int | None = None
        self._latch_ns = round(safety.t_latch_ms * NS_PER_MS)
        self.good = 0
        self._born_ns: int | None = None
        self._answered_ns = 0
        self._trouble: Reason | None = None
        self._late: Reason | None = None

    @property
    def soft_ns(self) -> int:
        """The age limit in force."""
        return self._limit.soft_ns

    @property
    def frames(self) -> int:
        """The number of good samples in a row that an engagement needs now."""
        if self._proven_ns is None or self._born_ns is None or self._born_ns - self._proven_ns > AGAIN_NS:
            return self._engagement_frames
        return min(self._engagement_frames, AGAIN_FRAMES)

    def limit_age(self, limit: AgeLimit) -> None:
        """Take note of the age limit in force."""
        self._limit = limit

    def restart(self) -> None:
        """Reset the count, as for a new local session."""
        self.distrust()
        self._born_ns = None

    def distrust(self) -> None:
        """Reset the count; what was seen before proves nothing."""
        self.good, self._proven_ns = 0, None

    def recount(self) -> None:
        """Reset the count, as at the beginning of a hold: samples that came before it do not end it."""
        self.good = 0

    def forget(self) -> None:
        """Reset the count, and drop what was wrong before, as for a new lease; its holder may be the same."""
        self.good, self._born_ns, self._trouble = 0, None, None

    def observe(self, result: Accepted | Rejected) -> None:
        """Take note of a judged sample."""
        if isinstance(result, Accepted):
            gap_ns = result.born_ns - self._born_ns if self._born_ns is not None else 0
            self.good = self.good + 1 if gap_ns <= self.soft_ns else 1
            self._born_ns, self._trouble, self._late = result.born_ns, None, None
            clock = result.sample.clock
            self._answered_ns = clock.measured_ns if clock is not None else 0
            if self.good >= self.frames:
                self._proven_ns = result.born_ns
        elif result.reason.code not in REPEATS:
            self.good = 0
            self._late = result.reason if result.reason.code is Code.STALE else None
            self._proven_ns = self._proven_ns if self._late is not None else None
            if result.hand_lost or result.reason.code in CLOCK_TROUBLE:
                self._trouble = result.reason

    def too_old(self, now_ns: int) -> Reason | None:
        """Say why the engagement must end; None while the newest good sample is younger than T_latch."""
        if self._age_ns(now_ns) <= self._latch_ns:
            return None
        return self._trouble or self._stale(now_ns, self._latch_ns)

    def unfit(self, now_ns: int) -> Reason | None:
        """Say why the newest hand sample must not be followed now."""
        if self._trouble is not None:
            return self._trouble
        if self._born_ns is None:
            return self._late or reason(Code.NO_HAND)
        return self._stale(now_ns, self.soft_ns) if self._age_ns(now_ns) > self.soft_ns else None

    def unanswered(self, now_ns: int) -> Reason | None:
        """Say why no engagement can begin: the questions that its sender asks the remote site are not answered."""
        age_ns = now_ns - self._answered_ns
        if age_ns <= ANSWERED_NS:
            return None
        return reason(Code.OLD_OFFSET, age_ms=age_ns / NS_PER_MS, limit_ms=ANSWERED_NS / NS_PER_MS)

    def too_slow(self) -> Reason | None:
        """Say why no engagement can begin with samples that come so old or so rarely."""
        return self._limit.too_slow

    def collecting(self, needed: int) -> Reason | None:
        """Say how many good samples are still missing; None if enough have come in a row."""
        return reason(Code.COLLECTING, count=min(self.good, needed), needed=needed) if self.good < needed else None

    def _age_ns(self, now_ns: int) -> int:
        return now_ns - self._born_ns if self._born_ns is not None else self._latch_ns + 1

    def _stale(self, now_ns: int, limit_ns: int) -> Reason:
        return reason(Code.STALE, age_ms=self._age_ns(now_ns) / NS_PER_MS, limit_ms=limit_ns / NS_PER_MS)
