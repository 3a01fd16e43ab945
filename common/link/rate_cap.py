"""A rate limiter that allows bursts, as a delay on the network bunches messages; without I/O."""

from common.clock import NS_PER_S


class RateCap:
    """Lets `burst` messages pass at once and `hz` per second in the long run: a token bucket, kept as one time (GCRA).

    `flooded` is set once a second's worth of messages (`hz`) had to wait, and cleared once as many did not.
    """

    def __init__(self, hz: float, burst: int) -> None:
        self._period_ns = round(NS_PER_S / hz)
        self._burst_ns = (burst - 1) * self._period_ns
        self._arrival_ns = 0  # when the next message would be due at exactly `hz`
        self._pauses, self._flood_pauses = 0, round(hz)
        self.flooded = False

    def pause_ns(self, now_ns: int) -> int:
        """How long to wait before taking the next message, ns; call once for each message, then `passed`."""
        pause_ns = max(0, self._arrival_ns - self._burst_ns - now_ns)
        self._count(1 if pause_ns else -1)
        return pause_ns

    def passed(self, now_ns: int) -> None:
        """Count a message that was taken at `now_ns`."""
        self._arrival_ns = max(self._arrival_ns, now_ns) + self._period_ns

    def _count(self, change: int) -> None:
        self._pauses = min(max(0, self._pauses + change), self._flood_pauses)
        if self._pauses in (0, self._flood_pauses):
            self.flooded = self._pauses > 0
