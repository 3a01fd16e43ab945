"""Rate that the link to the console carries, from what arrives and how late, and how much of that to use."""

import math
from collections import deque

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.video.streaming.sent_pictures import Arrivals

LEAST_BUCKET_NS = 2 * NS_PER_S
LEAST_BUCKETS = 10
USED = 0.7  # of what the link carries
LONGEST_MS = 500.0  # a link over which the sites connect: that its quickest pictures are older is a queue
LATE_MS = 80.0  # of queueing delay
ROOM_MS = 40.0  # more is tried while there is less of it
ALIKE = 0.7  # of the rate at which it was full before: so it is known
GROWING = 0.85  # less carried than this fraction of what was sent: the queue grows
IN_USE = 0.5  # of the budget: what is late although the link has room is late for another reason
LEAST_LEFT = 0.5  # of the last estimate after one report, since a pause of the link is not a slow link
PAUSE_NS = 300 * NS_PER_MS  # and two round trips: so long BBR sends next to nothing, every ten seconds
STANDING_NS = 500 * NS_PER_MS  # and two round trips: until a link counts as full whose queue does not grow
GONE_NS = NS_PER_S  # after less is sent a queue is gone
OPENING_REPORTS, OPENING_FRACTION = 3, 0.1  # little at first, so that there are quick pictures to compare with
QUICKER_MS = 10.0  # than all before: then the first ones may have waited
WAITING_MS = 100.0  # queueing delay in excess of which less and less is sent, so that the link drains
DRAINED_MS = 300.0
LEAST_DRAINING = 0.05
WINDOW_NS = 250 * NS_PER_MS  # and a round trip
MOST_REPORTS = 256  # far more than come in that time from a clock that runs
QUIET_NS = 2 * NS_PER_S
GROWTH_PER_S = 1.6
CAUTIOUS_GROWTH_PER_S = 1.03  # near the rate at which it was full twice; more quality is worth no late pictures
GROWTH_BEYOND_PER_S = 8.0
KNOWN = 2.0  # times what it carries now: nothing shows that a link carries more
BEYOND = 1.5  # more comes than when it was full: the link has changed, find out quickly
ENOUGH = 1.1
LONGEST_STEP_S = 1.0  # of growth for one report, however long the console says that it has not reported
LEAST_BYTES_PER_S = 10_000.0


class Least:
    """The least value of the last twenty seconds."""

    def __init__(self) -> None:
        self._buckets: deque[tuple[int, float]] = deque()
        self.value = math.inf

    def see(self, value: float, now_ns: int) -> float:
        """The least so far, this value included."""
        bucket = now_ns // LEAST_BUCKET_NS
        while self._buckets and self._buckets[0][0] <= bucket - LEAST_BUCKETS:
            self._buckets.popleft()
        if self._buckets and self._buckets[-1][0] >= bucket:
            bucket, least = self._buckets.pop()
            value = min(value, least)
        self._buckets.append((bucket, value))
        self.value = min(least for _, least in self._buckets)
        return self.value


class Lateness:
    """For how long pictures have been late, or held back again and again: what waits here is soon gone, and comes back.

    The time since then counts for late ones, and that between the first and the last for those that were held back.
    """

    def __init__(self) -> None:
        self._in_time_ns = self._first_held_ns = 0
        self._last_held_ns = -STANDING_NS

    def see(self, now_ns: int, *, late: bool, held_back: bool) -> int | None:
        """The longer of both, ns; None where nothing is late, and nothing was held back of late."""
        self._in_time_ns = self._in_time_ns if late else now_ns
        if held_back:
            if now_ns - self._last_held_ns >= STANDING_NS:
                self._first_held_ns = now_ns
            self._last_held_ns = now_ns
        if now_ns - self._last_held_ns >= STANDING_NS:
            return now_ns - self._in_time_ns if late else None
        return max(now_ns - self._in_time_ns, self._last_held_ns - self._first_held_ns)


class LinkRate:
    """An estimate of the link's rate, bytes a second; None while nothing has been late, when all is sent.

    One principle, that of delay-based congestion control (LEDBAT, RFC 6817; GCC, draft-ietf-rmcat-gcc-02; BBR): a
    queue is what a picture takes beyond the least of the last twenty seconds, however long the way itself is. While
    there is one, what comes is what the link carries; and before anything waits, a link holds that rate times its
    least round trip. Pictures that are held back, because earlier ones wait in this host, are such a queue too. What
    they have waited for a processor of either host is none: there a link seems full that carries all.

    The link is full when pictures have been late for longer than a pause of TCP (BBR measures the round trip every ten
    seconds: 200 ms and two round trips) and less comes than is sent, or when they have been late for some time without
    that. Pictures that are late although they were sent a second after the rate was reduced wait in no queue: the way
    has become longer, and the least is taken again. Meanwhile `draining` is the fraction of the budget that empties the
    link, at once and without a judgement.

    While nothing is late it is unknown whether the link carries more; after two quiet seconds a little more is tried,
    until all fits or pictures are late again. `full_ns` is when they were last late.
    """

    def __init__(self) -> None:
        self._carries: float | None = None
        self._when_full = 0.0  # and while it never was, what came last in time
        self._is_known = False
        self.full_ns = 0
        self.draining = 1.0
        self._opened_ns: int | None = None
        self._settled = 0
        self._least_delay, self._least_round_trip = Least(), Least()
        self._lateness = Lateness()
        self._reduced_ns: int | None = None
        self._reports: deque[tuple[int, Arrivals]] = deque(maxlen=MOST_REPORTS)

    def report(self, arrivals: Arrivals, wanted_bytes_per_s: float, now_ns: int, *, cautious: bool) -> None:
        """Take in what the console reported, how many bytes a second full quality would take, and how to try more."""
        before_ns = self._reports[-1][0] if self._reports else now_ns
        before_ms = self._least_delay.value
        delay_ms = min(LONGEST_MS, self._least_delay.see(arrivals.delay_ms, now_ns))
        round_trip_ms = min(LONGEST_MS, self._least_round_trip.see(arrivals.round_trip_ms, now_ns))
        round_trip_ns = round(round_trip_ms * NS_PER_MS)
        self._reports.append((now_ns, arrivals))
        while self._reports[0][0] < now_ns - WINDOW_NS - round_trip_ns:
            self._reports.popleft()
        if self.is_opening:
            self._open(before_ms - arrivals.delay_ms - arrivals.waited_ms, arrivals.round_trip_ms, now_ns)
        queue_ms = max(arrivals.delay_ms - delay_ms, arrivals.overdue_ms - round_trip_ms) - arrivals.waited_ms
        late_ns = self._lateness.see(now_ns, late=queue_ms > LATE_MS, held_back=arrivals.held_back)
        if late_ns is None:
            self._reduced_ns = None
            if self._carries is None:
                self._when_full = self._rate()
            elif now_ns - self.full_ns > QUIET_NS and queue_ms < ROOM_MS:
                self._try_more(self._carries, wanted_bytes_per_s, (now_ns - before_ns) / NS_PER_S, cautious=cautious)
        else:
            self._judge(late_ns - 2 * round_trip_ns, now_ns)
        if self._carries is not None and self._rate():
            queue_ms = 1000.0 * arrivals.waiting_bytes / self._carries - round_trip_ms
        self.draining = min(1.0, max(LEAST_DRAINING, 1.0 - (queue_ms - WAITING_MS) / DRAINED_MS))

    @property
    def is_opening(self) -> bool:
        """Return whether too little has come to know anything, or pictures still become quicker."""
        return self._settled < OPENING_REPORTS

    @property
    def carries(self) -> float | None:
        """The estimate of what the link carries, as far as it has been seen; None while all is sent."""
        return None if self._carries is None else min(self._carries, max(self._when_full, self._rate()))

    def budget(self, wanted_bytes_per_s: float) -> float | None:
        """Return how many bytes a second to send of those of full quality, None for all; less while it drains."""
        known = math.inf if self._carries is None else self._carries * USED
        budget = min(known, OPENING_FRACTION * wanted_bytes_per_s) if self.is_opening else known
        return budget if budget < math.inf else None

    def assume_free(self) -> None:
        """Everything is sent again, until something is late."""
        self._carries, self.draining, self._is_known = None, 1.0, False

    def _open(self, quicker_ms: float, round_trip_ms: float, now_ns: int) -> None:
        """Judge by how much quicker this report's pictures are than all before: those waited in a link that is full."""
        self._opened_ns = now_ns if self._opened_ns is None else self._opened_ns
        if now_ns - round_trip_ms * NS_PER_MS >= self._opened_ns:
            self._settled += quicker_ms < QUICKER_MS
        if LATE_MS < quicker_ms < math.inf:
            self._reduce(now_ns)

    def _judge(self, late_ns: int, now_ns: int) -> None:
        """Pictures are late, and have been for this time and a round trip."""
        carried = sum(arrivals.carried_bytes for _, arrivals in self._reports)
        sent = sum(arrivals.sent_bytes for _, arrivals in self._reports)
        is_used = self._carries is None or self._rate() > IN_USE * USED * self._carries
        seen_ns = now_ns - round(self._reports[-1][1].round_trip_ms * NS_PER_MS)
        if late_ns > PAUSE_NS and carried < GROWING * sent:
            if carried or self._reduced_ns is None:  # while nothing comes, nothing more is known
                self._reduce(now_ns)
        elif self._reduced_ns is not None and seen_ns - self._reduced_ns > GONE_NS:
            self._least_delay, self._least_round_trip, self._reduced_ns = Least(), Least(), None
        elif self._reduced_ns is None and late_ns > STANDING_NS:
            self._reduced_ns = now_ns
            if is_used:
                self._reduce(now_ns)
        if self._carries is not None:
            self.full_ns = now_ns

    def _reduce(self, now_ns: int) -> None:
        """The link is full: what comes is what it carries."""
        least = LEAST_BYTES_PER_S
        if self._carries is not None:
            least = max(least, LEAST_LEFT * self._carries)
        found = max(self._rate() or LEAST_LEFT * self._when_full, least)
        self._is_known = self._carries is not None and found > ALIKE * self._when_full
        self._carries = self._when_full = found
        self._reduced_ns = now_ns

    def _try_more(self, carries: float, wanted_bytes_per_s: float, seconds: float, *, cautious: bool) -> None:
        growth = CAUTIOUS_GROWTH_PER_S if cautious and self._is_known else GROWTH_PER_S
        growth = GROWTH_BEYOND_PER_S if self._rate() > BEYOND * self._when_full else growth
        more = min(carries * growth ** min(seconds, LONGEST_STEP_S), max(carries, KNOWN * self._rate()))
        self._carries = None if USED * more > ENOUGH * wanted_bytes_per_s else more

    def _rate(self) -> float:
        """Bytes a second that came over the last reports."""
        (first_ns, first), (last_ns, _) = self._reports[0], self._reports[-1]
        carried = sum(arrivals.carried_bytes for _, arrivals in self._reports) - first.carried_bytes
        return carried * NS_PER_S / (last_ns - first_ns) if last_ns > first_ns else 0.0
