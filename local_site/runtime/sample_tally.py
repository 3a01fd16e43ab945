"""Counts the hand samples of a run: how many, how many tracked, and the oldest of these when it was sent; pure."""

from dataclasses import dataclass

from common.clock import NS_PER_MS
from common.messages.hand import FOUND, TrackingStatus


@dataclass(slots=True)
class SampleTally:
    """`seen` are those tracked or degraded, `oldest_ns` the longest of their times from exposure to sending."""

    sent: int = 0
    seen: int = 0
    oldest_ns: int = 0

    def note(self, status: TrackingStatus, age_ns: int) -> None:
        """Count a sample that was sent, this long after its exposure."""
        self.sent += 1
        if status in FOUND:
            self.seen += 1
            self.oldest_ns = max(self.oldest_ns, age_ns)

    def __str__(self) -> str:
        tracked = f"{self.seen / self.sent:.0%} tracked" if self.sent else "none tracked"
        return f"{self.sent} sent, {tracked}, the oldest {self.oldest_ns / NS_PER_MS:.0f} ms from exposure to sending"
