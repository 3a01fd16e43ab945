"""Watch over a loop's turns: one that comes late is a pause, and turns that always do are a fault of its own."""

from common.clock import NS_PER_MS, NS_PER_S

LONGEST_TURN_NS = 50 * NS_PER_MS  # of control and of the driver's process, which take 4 and 2 ms
SLOW_NS, SLOW_TURNS = NS_PER_S, 5  # without one in time


class TurnWatch:
    """Feed it the begin of every turn. To be read: `took_ns`, how long the last one took.

    `slow_ns` is how long turns take on the average where each was too long for a second, five at least; else 0.
    """

    def __init__(self) -> None:
        self.took_ns = self.slow_ns = self._late = self._in_time_ns = 0
        self._turned_ns: int | None = None

    def note(self, now_ns: int) -> None:
        """A turn begins."""
        first, self.took_ns = self._turned_ns is None, now_ns - (self._turned_ns or now_ns)
        self._turned_ns = now_ns
        if first or self.took_ns <= LONGEST_TURN_NS:
            self._in_time_ns, self._late, self.slow_ns = now_ns, 0, 0
            return
        self._late += 1
        since_ns = now_ns - self._in_time_ns
        self.slow_ns = since_ns // self._late if self._late >= SLOW_TURNS and since_ns >= SLOW_NS else 0
