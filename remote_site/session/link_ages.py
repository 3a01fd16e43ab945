"""Ages that hand samples reach before the next one comes: what link and tracking need of the age limit; pure."""

from collections import deque
from statistics import median
from typing import NamedTuple

from common.clock import NS_PER_MS, NS_PER_S

WINDOW_S = 30  # what happened in this time counts
RECENT = 30  # samples, about a second: how the link is now
ENOUGH = 10  # samples, to judge how it is now
LONGEST_INTERVAL_NS = 50 * NS_PER_MS  # of the cameras: slower ones are no reason to obey older samples


class ArrivedSample(NamedTuple):
    """A sample's number, its capture by the sender's clock and, at the earliest, by ours, and when it arrived (ns)."""

    seq: int
    capture_ns: int
    born_ns: int
    now_ns: int

    @property
    def age_ns(self) -> int:
        """The greatest age that it can have had then."""
        return self.now_ns - self.born_ns


class LinkAges:
    """Keeps the greatest ages of the last 30 s; after a gap or an age beyond `outage_ns` the link was down, not slow.

    The age is the one that a sample reaches before the next one comes. The greatest of all is left out: what happened
    once is no property of the link.
    """

    def __init__(self, outage_ns: int) -> None:
        self._outage_ns = outage_ns
        self._last: ArrivedSample | None = None
        self._interval_ns = 0
        self._lost_ns: int | None = None
        self._seconds: deque[tuple[int, list[int]]] = deque()  # the two greatest ages of each second
        self._recent: deque[tuple[int, int]] = deque(maxlen=RECENT)
        self._spacings_ns: deque[int] = deque(maxlen=ENOUGH)

    def note(self, arrival: ArrivedSample) -> None:
        """Note a sample; one that has been overtaken says nothing."""
        last = self._last
        if last is not None and arrival.capture_ns <= last.capture_ns:
            return
        self._last = arrival
        if last is None or arrival.now_ns - last.now_ns > self._outage_ns:
            self._recent.clear()
            self._spacings_ns.clear()
            return
        sent = max(arrival.seq - last.seq, 1)
        spacing_ns = (arrival.capture_ns - last.capture_ns) // sent
        self._spacings_ns.append(spacing_ns)
        self._interval_ns = min(spacing_ns, LONGEST_INTERVAL_NS)
        if sent > 1:
            self._lost_ns = arrival.now_ns
        oldest_ns = arrival.age_ns + sent * self._interval_ns
        self._recent.append((arrival.age_ns, oldest_ns))
        if arrival.age_ns <= self._outage_ns:
            self._keep(oldest_ns, arrival.now_ns // NS_PER_S)

    def needed_ns(self, now_ns: int) -> int:
        """The age limit with which a link like this holds the arm hardly ever; 0 before anything is known.

        Where samples are lost, one more may be lost in a row.
        """
        oldest = now_ns - WINDOW_S * NS_PER_S
        while self._seconds and self._seconds[0][0] < oldest // NS_PER_S:
            self._seconds.popleft()
        greatest = sorted(age for _, ages in self._seconds for age in ages)[-2:]
        if not greatest:
            return 0
        loses = self._lost_ns is not None and self._lost_ns >= oldest
        return greatest[0] + (self._interval_ns if loses else 0)

    def usual_ns(self) -> tuple[int, int]:
        """The age at arrival, and before the next sample, that half of the last second's samples exceed; 0: unknown."""
        if len(self._recent) < ENOUGH:
            return 0, 0
        at_arrival, oldest = zip(*self._recent, strict=True)
        return round(median(at_arrival)), round(median(oldest))

    def spacing_ns(self) -> int:
        """Between the captures of two samples, what two of the last ten reach; 0: unknown."""
        return sorted(self._spacings_ns)[-2] if len(self._spacings_ns) == ENOUGH else 0

    def _keep(self, oldest_ns: int, second: int) -> None:
        if not self._seconds or self._seconds[-1][0] != second:
            self._seconds.append((second, []))
        greatest = self._seconds[-1][1]
        greatest.append(oldest_ns)
        greatest.sort(reverse=True)
        del greatest[2:]
