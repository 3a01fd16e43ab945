"""Whether another side is alive: fresh enough, by the times at which it was heard."""

from dataclasses import dataclass


@dataclass
class ChannelHealth:
    """Watches one channel; `change` tells once when it comes alive and once when it falls silent."""

    stale_after_ns: int
    last_ns: int | None = None
    alive: bool = False

    def seen(self, now_ns: int) -> None:
        """A valid message came."""
        self.last_ns = now_ns

    def change(self, now_ns: int) -> bool | None:
        """True when the channel has just come alive, False when it has just fallen silent, None without news."""
        alive = self.last_ns is not None and now_ns - self.last_ns <= self.stale_after_ns
        if alive == self.alive:
            return None
        self.alive = alive
        return alive


@dataclass
class Silence:
    """How long another side has been silent while this one listened.

    A listener that pauses itself, as when the whole machine stands still, hears nothing and can blame nobody: after
    more than `pause_ns` between two looks the silence counts anew.
    """

    pause_ns: int
    _looked_ns: int | None = None
    _resumed_ns: int = 0

    def of(self, last_ns: int, now_ns: int) -> int:
        """The silence in ns at `now_ns` of who was heard last at `last_ns`; to be asked again and again."""
        if self._looked_ns is not None and now_ns - self._looked_ns > self.pause_ns:
            self._resumed_ns = now_ns
        self._looked_ns = now_ns
        return now_ns - max(last_ns, self._resumed_ns)
