"""A rate limit with a burst, for messages that delay has bunched; pure."""

from common.clock import NS_PER_S


class RateCap:
    """Lets `burst` messages pass immediately and `hz` per second in the long run.

    `flooded` is set after a second of pauses, and cleared once as many messages have passed without one.
    """

    def __init__(self, hz: float, burst: int) -> None:
        self._period_ns = round(NS_PER_S / hz)
        self._room_ns = (burst - 1) * self._period_ns
        self._spent_until_ns = 0
        self._pauses, self._many_pauses = 0, round(hz)
        self.flooded = False

    def pause_ns(self, now_ns: int) -> int:
        """How long to wait before taking the next message, ns; call once for each."""
        pause_ns = max(0, self._spent_until_ns - self._room_ns - now_ns)
        self._count(1 if pause_ns else -1)
        return pause_ns

    def passed(self, now_ns: int) -> None:
        """Note that a message has been taken."""
        self._spent_until_ns = max(self._spent_until_ns, now_ns) + self._period_ns

    def _count(self, change: int) -> None:
        self._pauses = min(max(0, self._pauses + change), self._many_pauses)
        if self._pauses in (0, self._many_pauses):
            self.flooded = self._pauses > 0
