"""A rate limit that allows bursts, as a delay on the network bunches messages; pure."""

from common.clock import NS_PER_S


class RateCap:
    """Lets `burst` messages pass immediately and `hz` per second in the long run (generic cell rate algorithm).

    `flooded` is set when a second's worth of messages (`hz`) had to wait, and cleared when as many passed undelayed.
    """

    def __init__(self, hz: float, burst: int) -> None:
        self._period_ns = round(NS_PER_S / hz)
        self._tolerance_ns = (burst - 1) * self._period_ns
        self._due_ns = 0
        self._delayed, self._flood = 0, round(hz)
        self.flooded = False

    def pause_ns(self, now_ns: int) -> int:
        """Return how long to wait before the next message, ns; call once per message, as it counts for `flooded`."""
        pause_ns = max(0, self._due_ns - self._tolerance_ns - now_ns)
        self._count(1 if pause_ns else -1)
        return pause_ns

    def passed(self, now_ns: int) -> None:
        """Note that a message has been taken."""
        self._due_ns = max(self._due_ns, now_ns) + self._period_ns

    def _count(self, change: int) -> None:
        self._delayed = min(max(0, self._delayed + change), self._flood)
        if self._delayed in (0, self._flood):
            self.flooded = self._delayed > 0
