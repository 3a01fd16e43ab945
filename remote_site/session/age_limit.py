"""T_soft, the age up to which hand samples are obeyed, fixed or chosen from the link, and the speed it leaves; pure."""

from typing import NamedTuple

from common.clock import NS_PER_MS
from common.messages.hand import HandArm, TrackingStatus
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import FULL_SPEED_MS, SafetyConfig
from remote_site.session.link_ages import ArrivedSample, LinkAges

FULL_SPEED_NS = round(FULL_SPEED_MS * NS_PER_MS)
MOST_NS = 400 * NS_PER_MS
LATCH_FRACTION = 0.8  # of T_latch: a hold comes before the end of the engagement
STEP_NS = 25 * NS_PER_MS
SPARE_NS = 5 * NS_PER_MS


class AgeLimit(NamedTuple):
    """The age limit in force, `soft_ns`, and the fraction of full speed that it leaves, or a longer one to follow it.

    `too_slow` is why nothing can be operated over this link, or with samples that come so rarely; None while it can.
    """

    soft_ns: int
    speed_scale: float
    too_slow: Reason | None

    @property
    def stretch(self) -> float:
        """The factor by which targets are extrapolated for longer than at full speed, for an arm that is slower."""
        return max(self.soft_ns / FULL_SPEED_NS, 1.0)


class AgeLimitChoice:
    """Chooses the limit from the link; the speed that is allowed falls in proportion where it is above 100 ms.

    A limit of its own choice shrinks by itself. It grows at rest; in motion the arm is slowed first, and the limit
    follows once no joint is faster than it allows.
    """

    def __init__(self, config: SafetyConfig) -> None:
        self._outage_ns = round(config.t_latch_ms * NS_PER_MS)
        self._most_ns = min(MOST_NS, round(LATCH_FRACTION * self._outage_ns))
        self._least_ns = min(FULL_SPEED_NS, self._most_ns)
        fixed = None if isinstance(config.t_soft_ms, str) else round(config.t_soft_ms * NS_PER_MS)
        self._is_fixed = fixed is not None
        self._ages = LinkAges(self._outage_ns)
        self._soft_ns = fixed or self._least_ns
        self._wanted_ns = self._soft_ns
        self._session: int | None = None
        self._spacing_ns = 0
        self._too_old: Reason | None = None

    def see(self, sample: HandArm, born_ns: int, now_ns: int) -> None:
        """Note a sample that arrived, young enough or not; at the earliest it was captured at `born_ns`.

        While a tracker still learns the arm it takes longer, but nothing is followed: that tells nothing of later ones.
        Nor does a sample from the future.
        """
        if sample.status is TrackingStatus.INITIALISING or born_ns > now_ns:
            return
        if sample.session != self._session:
            self._session, self._ages = sample.session, LinkAges(self._outage_ns)
        self._ages.note(ArrivedSample(sample.seq, sample.capture_ns, born_ns, now_ns))
        self._spacing_ns = self._ages.spacing_ns()
        if self._is_fixed:
            return
        self._too_old = self._beyond_any_limit()
        needed_ns = self._ages.needed_ns(now_ns) + SPARE_NS
        steps_ns = -(-needed_ns // STEP_NS) * STEP_NS
        self._wanted_ns = min(max(steps_ns, self._least_ns), self._most_ns)

    def settle(self, pace: float) -> AgeLimit:
        """Let the limit in force follow the link, for joints at `pace`, a fraction of their greatest speed."""
        if self._wanted_ns <= self._soft_ns or pace <= speed_scale_at(self._wanted_ns):
            self._soft_ns = self._wanted_ns
        return self.limit

    @property
    def limit(self) -> AgeLimit:
        """The limit in force, with what the link has shown since it was settled."""
        scale = speed_scale_at(max(self._soft_ns, self._wanted_ns))
        return AgeLimit(self._soft_ns, scale, self._too_old or self._too_rare())

    @property
    def range_ns(self) -> tuple[int, int]:
        """The shortest and the longest limit that can be in force."""
        return (self._soft_ns, self._soft_ns) if self._is_fixed else (self._least_ns, self._most_ns)

    def _beyond_any_limit(self) -> Reason | None:
        """Say why this link cannot be operated: most of its samples grow older than any limit allows."""
        age_ns, oldest_ns = self._ages.usual_ns()
        if oldest_ns <= self._most_ns:
            return None
        most_ns = self._most_ns - (oldest_ns - age_ns)
        return reason(Code.LINK_TOO_SLOW, age_ms=age_ns / NS_PER_MS, most_ms=most_ns / NS_PER_MS)

    def _too_rare(self) -> Reason | None:
        """Say why no samples come in a row without a gap beyond the limit: their sender captures too few a second."""
        if self._spacing_ns < self._soft_ns:
            return None
        return reason(Code.SAMPLES_RARE, interval_ms=self._spacing_ns / NS_PER_MS, limit_ms=self._soft_ns / NS_PER_MS)


def speed_scale_at(soft_ns: int) -> float:
    """The fraction of full speed that an age limit leaves."""
    return min(1.0, FULL_SPEED_NS / soft_ns)
