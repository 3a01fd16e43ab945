"""How much load may be on its way at once, and what the link carries of it: bounded, so that its queues stay short."""

from common.clock import NS_PER_MS, NS_PER_S

FIRST_BYTES, MOST_BYTES = 1 << 16, 1 << 21
LEAST_ROUND_NS = 50 * NS_PER_MS  # beyond a round trip, so that there is load to judge
QUEUED_NS = 100 * NS_PER_MS  # what takes longer than a round trip by this has waited: the link is full
LOST_NS = 3 * NS_PER_S


class LoadWindow:
    """Grows twofold as long as the quickest load since it last grew has waited little; times in ns of one clock."""

    def __init__(self, round_trip_ns: int, now_ns: int) -> None:
        self._round_trip_ns = round_trip_ns
        self._window = FIRST_BYTES
        self._sent: dict[int, tuple[int, int]] = {}  # number: when, and how many bytes
        self._arrived: list[tuple[int, int]] = []
        self._grown_ns, self._least_age_ns = now_ns, LOST_NS

    def has_room(self, now_ns: int) -> bool:
        """Whether more may be sent now."""
        return self.on_its_way(now_ns) < self._window

    def on_its_way(self, now_ns: int) -> int:
        """The bytes that have not arrived; what has not come for LOST_NS counts as lost."""
        self._sent = {number: sent for number, sent in self._sent.items() if now_ns - sent[0] < LOST_NS}
        return sum(size for _, size in self._sent.values())

    def sent(self, number: int, size: int, now_ns: int) -> None:
        """Load of this number and size in bytes was sent."""
        self._sent[number] = now_ns, size

    def arrived(self, number: int, now_ns: int) -> None:
        """It has arrived, as an echo reports."""
        if number not in self._sent:
            return
        sent_ns, size = self._sent.pop(number)
        self._arrived.append((now_ns, size))
        if sent_ns < self._grown_ns + self._round_trip_ns // 2:
            return  # the queue was still that of the smaller window
        self._least_age_ns = min(self._least_age_ns, now_ns - sent_ns)
        if now_ns - self._grown_ns >= self._round_trip_ns + LEAST_ROUND_NS:
            if self._least_age_ns < self._round_trip_ns + QUEUED_NS:
                self._window = min(2 * self._window, MOST_BYTES)
            self._grown_ns, self._least_age_ns = now_ns, LOST_NS

    def mbit_s(self) -> float:
        """What arrived in the later half of the time in which anything did; 0 where hardly anything did."""
        if not self._arrived:
            return 0.0
        first_ns, last_ns = self._arrived[0][0], self._arrived[-1][0]
        middle_ns = (first_ns + last_ns) // 2
        counted = sum(size for t_ns, size in self._arrived if t_ns > middle_ns)
        return counted * 8e3 / (last_ns - middle_ns) if last_ns > middle_ns else 0.0
