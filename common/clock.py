"""Units of time, what a clock is, a fake one for tests, and the offset between two hosts' clocks; pure."""

from collections import deque
from dataclasses import dataclass
from typing import Protocol

NS_PER_MS = 1_000_000
NS_PER_S = 1_000_000_000

HEARD_NS = 4 * NS_PER_S  # without a round trip for longer, nothing is known
KEPT_NS = 120 * NS_PER_S
DRIFT = 10_000  # two clocks drift apart by at most one nanosecond in this many: 100 parts per million
# One nanosecond in this many, 2 ms a second: where the link becomes slower, the uncertainty is to rise to what can be
# measured now, and not to jump there.
DISPERSION = 500


class Clock(Protocol):
    """A source of monotonic nanoseconds that can wait."""

    def now_ns(self) -> int: ...

    def sleep_until_ns(self, deadline_ns: int) -> None: ...


@dataclass
class FakeClock:
    """A clock that tests advance; sleeping advances it to the deadline."""

    time_ns: int = 0

    def now_ns(self) -> int:
        return self.time_ns

    def sleep_until_ns(self, deadline_ns: int) -> None:
        self.time_ns = max(self.time_ns, deadline_ns)

    def advance_ms(self, milliseconds: float) -> None:
        self.time_ns += round(milliseconds * NS_PER_MS)


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """The other host's clock minus ours and the bound of its error, both in nanoseconds."""

    offset_ns: int
    uncertainty_ns: int

    def age_ns(self, stamp_ns: int, now_ns: int) -> int:
        """Upper bound of the age of a time stamp by the other host's clock."""
        return now_ns - (stamp_ns - self.offset_ns) + self.uncertainty_ns


@dataclass(frozen=True, slots=True)
class RoundTrip:
    """One query of the other host's clock, ns: `asked_ns` and `reply_ns` by our clock, the other two by the other's."""

    asked_ns: int
    received_ns: int
    answered_ns: int
    reply_ns: int

    @property
    def duration_ns(self) -> int:
        """The time that query and answer spent in transit."""
        return (self.reply_ns - self.asked_ns) - (self.answered_ns - self.received_ns)

    @property
    def offset_ns(self) -> int:
        """The other clock minus ours, assuming equal transit times; off by half the duration at most."""
        return ((self.received_ns - self.asked_ns) + (self.answered_ns - self.reply_ns)) // 2

    @property
    def possible(self) -> bool:
        """Return whether two monotonic clocks can have given these times."""
        return self.answered_ns >= self.received_ns and self.duration_ns >= 0

    def error_bound_ns(self, now_ns: int) -> int:
        """Half the duration, as transit times may differ, and the possible drift since."""
        return self.duration_ns // 2 + 1 + max(0, now_ns - self.reply_ns) // DRIFT

    def uncertainty_ns(self, now_ns: int) -> int:
        """Half the duration, and the dispersion since: as in NTP (RFC 5905), with a greater rate."""
        return self.duration_ns // 2 + 1 + max(0, now_ns - self.reply_ns) // DISPERSION


@dataclass(frozen=True, slots=True)
class ClockEstimate:
    """The best estimate of the offset, and the time by the other clock of the newest round trip that agrees with it.

    `their_ahead_ns` is by how much steady time was ahead of the other clock then, None where that is not told.
    """

    offset: ClockOffset
    measured_ns: int
    their_ahead_ns: int | None = None

    def of_stamp(self, ahead_ns: int | None) -> ClockOffset:
        """The offset for a stamp of the other clock that steady time led by `ahead_ns`, None if not reported."""
        if ahead_ns is None or self.their_ahead_ns is None:
            return self.offset
        return ClockOffset(self.offset.offset_ns + self.their_ahead_ns - ahead_ns, self.offset.uncertainty_ns)


class OffsetEstimator:
    """Keeps the round trips that may be the most certain one now or later; the most certain one gives the estimate."""

    def __init__(self) -> None:
        self._newest: RoundTrip | None = None
        self._best: deque[RoundTrip] = deque()  # the most certain first; the others are newer, for when it expires

    def add(self, trip: RoundTrip) -> None:
        """Add a round trip; one that contradicts those before it shows that a clock was reset, and replaces them."""
        if not trip.possible:
            return
        now_ns = trip.reply_ns
        if self._contradicted(trip):
            self._best.clear()
        while self._best and self._best[-1].uncertainty_ns(now_ns) >= trip.uncertainty_ns(now_ns):
            self._best.pop()
        self._best.append(trip)
        self._newest = trip

    def estimate(self, now_ns: int) -> ClockEstimate | None:
        """The other clock minus ours; None without a round trip in the last four seconds."""
        if self._newest is None or now_ns - self._newest.reply_ns > HEARD_NS:
            return None
        while len(self._best) > 1 and now_ns - self._best[0].reply_ns > KEPT_NS:
            self._best.popleft()
        best = self._best[0]
        return ClockEstimate(ClockOffset(best.offset_ns, best.uncertainty_ns(now_ns)), self._newest.answered_ns)

    def _contradicted(self, trip: RoundTrip) -> bool:
        if self.estimate(trip.reply_ns) is None:
            return False
        best, now_ns = self._best[0], trip.reply_ns
        apart_ns = abs(trip.offset_ns - best.offset_ns)
        return apart_ns > best.error_bound_ns(now_ns) + trip.error_bound_ns(now_ns)
