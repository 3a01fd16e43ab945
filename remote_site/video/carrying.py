"""How much the link to the console carries, from what arrives and how late; and what to use of it. Pure."""

from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S

USED = 0.7  # of what the link carries
LATE_MS = 80.0  # behind the quickest pictures
GROWING = 0.85  # less carried than this share of what was sent: it is the link that is late
LATE_REPORTS, STANDING_REPORTS = 2, 5  # until a link counts as full whose queue grows, or only stands
OPENING_REPORTS, OPENING_SHARE = 4, 0.25  # little at first, so that there are quick pictures to compare with
WAITING_MS = 100.0  # what may be on its way in excess; beyond it less and less is sent, so that the link drains
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
class News:
    """What one report says of the pictures that were new in it.

    Since the last report `sent_bytes` went out and `carried_bytes` came; `waiting_bytes` are still on their way.
    `delay_ms` is how much later than the quickest they came, and `least_age_ms` how old the quickest are.
    """

    sent_bytes: int
    carried_bytes: int
    waiting_bytes: int
    delay_ms: float
    least_age_ms: float


class Carrying:
    """An estimate of the link's rate, bytes a second; None while nothing has been late, when all is sent.

    What comes out of a link in which pictures wait is what the link carries. While none wait nobody can know whether
    it carries more; after three quiet seconds a little more is tried, until all fits or something is late again.
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
        self._reports: deque[tuple[int, News]] = deque()

    def report(self, news: News, wanted_bytes_per_s: float, now_ns: int) -> None:
        """What the console has shown, and how many bytes a second full quality would take."""
        before_ns = self._reports[-1][0] if self._reports else now_ns
        self._count += 1
        self._reports.append((now_ns, news))
        while self._reports[0][0] < now_ns - WINDOW_NS:
            self._reports.popleft()
        late = max(news.delay_ms, _excess_ms(news, self._rate())) > LATE_MS
        self._late_reports = self._late_reports + 1 if late else 0
        self._is_full = late and (self._is_full or self._became_full())
        if self._is_full:
            self._carries = self._when_full = max(self._rate(), LEAST_BYTES_PER_S)
            self._full_ns = now_ns
        elif self._carries is not None and now_ns - self._full_ns > QUIET_NS:
            self._try_more(self._carries, wanted_bytes_per_s, now_ns - before_ns)
        if self._carries is not None:
            excess_ms = _excess_ms(news, self._carries)
            self._draining = min(1.0, max(LEAST_DRAINING, 1.0 - (excess_ms - WAITING_MS) / DRAINED_MS))

    def budget(self, wanted_bytes_per_s: float) -> float | None:
        """How many bytes a second to send of those that full quality would take, None for all."""
        if self._count < OPENING_REPORTS:
            return OPENING_SHARE * wanted_bytes_per_s
        return None if self._carries is None else self._carries * USED * self._draining

    def _became_full(self) -> bool:
        carried = sum(news.carried_bytes for _, news in self._reports)
        sent = sum(news.sent_bytes for _, news in self._reports)
        grows = self._late_reports >= LATE_REPORTS and carried < GROWING * sent
        return grows or self._late_reports >= STANDING_REPORTS

    def _try_more(self, carries: float, wanted_bytes_per_s: float, passed_ns: int) -> None:
        growth = GROWTH_BEYOND_PER_S if carries > BEYOND * self._when_full else GROWTH_PER_S
        more = carries * growth ** (passed_ns / NS_PER_S)
        self._carries = None if USED * more > ENOUGH * wanted_bytes_per_s else more

    def _rate(self) -> float:
        """Bytes a second that came over the last reports."""
        (first_ns, first), (last_ns, _) = self._reports[0], self._reports[-1]
        carried = sum(news.carried_bytes for _, news in self._reports) - first.carried_bytes
        return carried * NS_PER_S / (last_ns - first_ns) if last_ns > first_ns else 0.0


def _excess_ms(news: News, carries: float) -> float:
    """How long the link has still to do with what waits, beyond the time that a picture takes at best."""
    return 1000.0 * news.waiting_bytes / carries - news.least_age_ms if carries else 0.0
