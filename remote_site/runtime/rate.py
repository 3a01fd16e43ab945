"""A fixed-rate loop on absolute deadlines: lateness recorded, overruns counted, no burst after a delay."""

from collections import deque
from collections.abc import Sequence

from common.clock import NS_PER_S, Clock

LATENESS_SAMPLES = 4096


class Rate:
    """Paces a loop at `hz`; a deadline missed by a whole period is counted and skipped.

    After a late wake-up the next comes no sooner than `least_fraction` of a period: its deadline and all later ones
    are postponed. `next_ns` is the next deadline.
    """

    def __init__(self, hz: float, clock: Clock, *, least_fraction: float = 0.0) -> None:
        self.period_ns = round(NS_PER_S / hz)
        self._least_ns = round(least_fraction * self.period_ns)
        self._clock = clock
        self._start_ns = clock.now_ns()
        self._deadline_ns = self._start_ns
        self.next_ns = self._start_ns + self.period_ns
        self._lateness_ns: deque[int] = deque(maxlen=LATENESS_SAMPLES)
        self.ticks = 0
        self.missed = 0

    def wait(self) -> int:
        """Sleep until the next deadline and return its time in ns; the wake-up's lateness is recorded."""
        self._clock.sleep_until_ns(self.next_ns)
        now_ns = self._clock.now_ns()
        late_ns = now_ns - self.next_ns
        self._lateness_ns.append(late_ns)
        self.ticks += 1
        skipped = max(late_ns // self.period_ns, 0)
        self.missed += skipped
        self._deadline_ns = self.next_ns + skipped * self.period_ns
        self.next_ns = max(self._deadline_ns + self.period_ns, now_ns + self._least_ns)
        return self._deadline_ns

    @property
    def hz(self) -> float:
        """The rate really kept, in Hz."""
        elapsed_ns = self._deadline_ns - self._start_ns
        return self.ticks * NS_PER_S / elapsed_ns if elapsed_ns > 0 else 0.0

    def late_us(self, percentile: float) -> float:
        """A percentile (0-100) of the wake-up lateness of the last 4096 ticks, in microseconds."""
        return percentile_of(sorted(self._lateness_ns), percentile) / 1000.0


def percentile_of(ordered: Sequence[float], percentile: float) -> float:
    """The nearest-rank percentile of ordered values, 0 when there are none."""
    if not ordered:
        return 0.0
    return ordered[min(len(ordered) - 1, int(len(ordered) * percentile / 100.0))]
