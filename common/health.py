"""Whether a channel is alive: fresh enough, by the times at which its messages came."""

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
