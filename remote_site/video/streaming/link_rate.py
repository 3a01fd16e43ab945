"""How much the link to the console carries, from what arrives and how late, and how much of that to use."""

from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.video import ViewCame

MOST_WAITING = 256
AGE_BUCKET_NS = 2 * NS_PER_S
AGE_BUCKETS = 10
SMOOTHING = 0.3
TOO_OLD_MS = 250.0  # late, however old the quickest are: a link that was full at first shows no quick ones
USED = 0.7  # of what the link carries
LATE_MS = 80.0  # behind the quickest pictures
GROWING = 0.85  # less carried than this fraction of what was sent: it is the link that is late
LATE_REPORTS, CONSTANT_REPORTS = 2, 5  # until a link counts as full whose queue grows, or is only constant
OPENING_REPORTS, OPENING_FRACTION = 4, 0.25  # little at first, so that there are quick pictures to compare with
WAITING_MS = 100.0  # queueing delay in excess of which less and less is sent, so that the link drains
DRAINED_MS = 300.0
LEAST_DRAINING = 0.05
WINDOW_NS = 250 * NS_PER_MS
QUIET_NS = 3 * NS_PER_S
GROWTH_PER_S = 1.6
GROWTH_BEYOND_PER_S = 6.0
BEYOND = 1.5  # of what it carried when last it was late: the link has changed, find out quickly
ENOUGH = 1.1
LEAST_BYTES_PER_S = 10_000.0


@dataclass(frozen=True, slots=True)
class Arrivals:
    """What one report adds about the pictures that were new in it.

    Since the last report `sent_bytes` went out and `carried_bytes` came; `waiting_bytes` are still in the link.
    `delay_ms` is how much later than the quickest they came, and `least_age_ms` how old the quickest are.
    """

    sent_bytes: int
    carried_bytes: int
    waiting_bytes: int
    delay_ms: float
    least_age_ms: float


class SentPictures:
    """What was sent of one camera; bytes count as carried once a picture sent with or after them has come.

    `reference_bytes` is what a picture of quality 80 at full size takes, None before the first; `sent_ns` is when the
    last one was sent.
    """

    def __init__(self) -> None:
        self.reference_bytes: float | None = None
        self.sent_ns = 0
        self._waiting: deque[tuple[int, int]] = deque(maxlen=MOST_WAITING)  # number and bytes
        self._least_ages: deque[tuple[int, float]] = deque(maxlen=AGE_BUCKETS)
        self._come_seq = -1
        self._sent_bytes = 0

    def send(self, seq: int, size: int, relative_bytes: float, now_ns: int) -> None:
        """A picture of `size` bytes went out; its setting makes `relative_bytes` of the reference's size."""
        self._waiting.append((seq, size))
        self.sent_ns = now_ns
        self._sent_bytes += size
        reference = size / relative_bytes
        known = reference if self.reference_bytes is None else self.reference_bytes
        self.reference_bytes = known + SMOOTHING * (reference - known)

    def come(self, came: ViewCame, now_ns: int) -> Arrivals | None:
        """What a console reports of this camera; None when nothing new has come."""
        if came.seq <= self._come_seq:
            return None
        self._come_seq = came.seq
        carried, sent, self._sent_bytes = 0, self._sent_bytes, 0
        while self._waiting and self._waiting[0][0] <= came.seq:
            carried += self._waiting.popleft()[1]
        least_ms, waiting = self._least_age(came.age_ms, now_ns), sum(size for _, size in self._waiting)
        return Arrivals(sent, carried, waiting, max(came.age_ms - least_ms, came.age_ms - TOO_OLD_MS), least_ms)

    def forget(self) -> None:
        """Another console reports, or none: nothing that it has shown counts any more."""
        self._waiting.clear()
        self._least_ages.clear()
        self._come_seq = -1
        self._sent_bytes = 0

    def _least_age(self, age_ms: float, now_ns: int) -> float:
        """The least age of the last twenty seconds: the latency when nothing waits."""
        bucket = now_ns // AGE_BUCKET_NS
        while self._least_ages and self._least_ages[0][0] <= bucket - AGE_BUCKETS:
            self._least_ages.popleft()
        if self._least_ages and self._least_ages[-1][0] == bucket:
            self._least_ages[-1] = (bucket, min(age_ms, self._least_ages[-1][1]))
        else:
            self._least_ages.append((bucket, age_ms))
        return min(age for _, age in self._least_ages)


class LinkRate:
    """An estimate of the link's rate, bytes a second; None while nothing has been late, when all is sent.

    What comes out of a link in which pictures wait is what the link carries. While none wait it is unknown whether it
    carries more; after three quiet seconds a little more is tried, until all fits or something is late again.
    Pictures that are late although all that is sent arrives are late for another reason, such as a busy host.
    """

    def __init__(self) -> None:
        self._carries: float | None = None
        self._when_full = 0.0
        self._full_ns = 0
        self._is_full = False
        self._count = 0
        self._late_reports = 0
        self._draining = 1.0
        self._reports: deque[tuple[int, Arrivals]] = deque()

    def report(self, arrivals: Arrivals, wanted_bytes_per_s: float, now_ns: int) -> None:
        """What the console has shown, and how many bytes a second full quality would take."""
        before_ns = self._reports[-1][0] if self._reports else now_ns
        self._count += 1
        self._reports.append((now_ns, arrivals))
        while self._reports[0][0] < now_ns - WINDOW_NS:
            self._reports.popleft()
        late = max(arrivals.delay_ms, _excess_ms(arrivals, self._rate())) > LATE_MS
        self._late_reports = self._late_reports + 1 if late else 0
        self._is_full = late and (self._is_full or self._became_full())
        if self._is_full:
            self._carries = self._when_full = max(self._rate(), LEAST_BYTES_PER_S)
            self._full_ns = now_ns
        elif self._carries is not None and now_ns - self._full_ns > QUIET_NS:
            self._try_more(self._carries, wanted_bytes_per_s, now_ns - before_ns)
        if self._carries is not None:
            excess_ms = _excess_ms(arrivals, self._carries)
            self._draining = min(1.0, max(LEAST_DRAINING, 1.0 - (excess_ms - WAITING_MS) / DRAINED_MS))

    def budget(self, wanted_bytes_per_s: float) -> float | None:
        """How many bytes a second to send of those that full quality would take, None for all."""
        if self._count < OPENING_REPORTS:
            return OPENING_FRACTION * wanted_bytes_per_s
        return None if self._carries is None else self._carries * USED * self._draining

    def _became_full(self) -> bool:
        carried = sum(arrivals.carried_bytes for _, arrivals in self._reports)
        sent = sum(arrivals.sent_bytes for _, arrivals in self._reports)
        grows = self._late_reports >= LATE_REPORTS and carried < GROWING * sent
        return grows or self._late_reports >= CONSTANT_REPORTS

    def _try_more(self, carries: float, wanted_bytes_per_s: float, passed_ns: int) -> None:
        growth = GROWTH_BEYOND_PER_S if carries > BEYOND * self._when_full else GROWTH_PER_S
        more = carries * growth ** (passed_ns / NS_PER_S)
        self._carries = None if USED * more > ENOUGH * wanted_bytes_per_s else more

    def _rate(self) -> float:
        """Bytes a second that came over the last reports."""
        (first_ns, first), (last_ns, _) = self._reports[0], self._reports[-1]
        carried = sum(arrivals.carried_bytes for _, arrivals in self._reports) - first.carried_bytes
        return carried * NS_PER_S / (last_ns - first_ns) if last_ns > first_ns else 0.0


def _excess_ms(arrivals: Arrivals, carries: float) -> float:
    """The queueing delay of what waits, beyond the least latency of a picture."""
    return 1000.0 * arrivals.waiting_bytes / carries - arrivals.least_age_ms if carries else 0.0
