"""How much the link to the console carries, from what arrives and how late; and what to use of it. Pure."""

from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S

USED = 0.7  # of what the link carries
LATE_MS = 80.0  # behind the quickest pictures, twice: something waits in the link
VERY_LATE_MS = 160.0  # once
WAITING_MS = 100.0  # what may be on its way in excess; beyond it less and less is sent, so that the link drains
DRAINED_MS = 300.0
LEAST_DRAINING = 0.05
WINDOW_NS = 250 * NS_PER_MS
QUIET_NS = 2 * NS_PER_S
GROWTH_PER_S = 1.6
GROWTH_BEYOND_PER_S = 6.0
BEYOND = 1.5  # of what it carried when last it was late: the link has changed, find out quickly
ENOUGH = 1.1
LEAST_BYTES_PER_S = 10_000.0


@dataclass(frozen=True, slots=True)
class News:
    """What one report says of the pictures that were new in it.

    `carried_bytes` came since the last report and `waiting_bytes` are still on their way; `delay_ms` is how much later
    than the quickest they came, and `least_age_ms` how old the quickest are.
    """

    carried_bytes: int
    waiting_bytes: int
    delay_ms: float
    least_age_ms: float


class Carrying:
    """An estimate of the link's rate, bytes a second; None while nothing has been late, when all is sent.

    What comes out of a link in which pictures wait is what the link carries. While none wait nobody can know whether
    it carries more; after two quiet seconds a little more is tried, until all fits or something is late again.
    """

    def __init__(self) -> None:
        self._carries: float | None = None
        self._when_late = 0.0
        self._late_ns = 0
        self._reports: deque[tuple[int, int]] = deque()
        self._late_ms = 0.0
        self._draining = 1.0

    def report(self, news: News, wanted_bytes_per_s: float, now_ns: int) -> None:
        """What the console has shown, and how many bytes a second full quality would take."""
        before_ns = self._reports[-1][0] if self._reports else now_ns
        self._reports.append((now_ns, news.carried_bytes))
        while self._reports[0][0] < now_ns - WINDOW_NS:
            self._reports.popleft()
        late_ms = max(news.delay_ms, self._excess_ms(news, self._rate()))
        before_ms, self._late_ms = self._late_ms, late_ms
        if news.delay_ms > VERY_LATE_MS or min(late_ms, before_ms) > LATE_MS:
            self._carries = self._when_late = max(self._rate(), LEAST_BYTES_PER_S)
            self._late_ns = now_ns
        elif self._carries is not None and now_ns - self._late_ns > QUIET_NS:
            self._try_more(self._carries, wanted_bytes_per_s, now_ns - before_ns)
        if self._carries is not None:
            excess_ms = self._excess_ms(news, self._carries)
            self._draining = min(1.0, max(LEAST_DRAINING, 1.0 - (excess_ms - WAITING_MS) / DRAINED_MS))

    @property
    def budget(self) -> float | None:
        """How many bytes a second to send, None for all."""
        if self._carries is None:
            return None
        return self._carries * USED * self._draining

    def _try_more(self, carries: float, wanted_bytes_per_s: float, passed_ns: int) -> None:
        growth = GROWTH_BEYOND_PER_S if carries > BEYOND * self._when_late else GROWTH_PER_S
        more = carries * growth ** (passed_ns / NS_PER_S)
        self._carries = None if USED * more > ENOUGH * wanted_bytes_per_s else more

    def _excess_ms(self, news: News, carries: float) -> float:
        """How long the link has still to do with what waits, beyond the time that a picture takes at best."""
        return 1000.0 * news.waiting_bytes / carries - news.least_age_ms if carries else 0.0

    def _rate(self) -> float:
        """Bytes a second over the last reports."""
        (first_ns, _), (last_ns, _) = self._reports[0], self._reports[-1]
        carried = sum(size for _, size in self._reports) - self._reports[0][1]
        return carried * NS_PER_S / (last_ns - first_ns) if last_ns > first_ns else 0.0
