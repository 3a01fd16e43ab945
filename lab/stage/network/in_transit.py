"""What is under way over a modelled link: put in with its time of arrival, taken out when that has come."""

import heapq
from dataclasses import dataclass, field
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass
class InTransit(Generic[T]):
    """Things under way, in one direction; `in_order`, none overtakes one that was sent before it."""

    in_order: bool = True
    _waiting: list[tuple[int, int, T]] = field(default_factory=list)
    _sent: int = 0
    _last_ns: int = 0

    def send(self, thing: T, arrives_ns: int) -> None:
        """Put in what arrives at a time, ns."""
        if self.in_order:
            arrives_ns = self._last_ns = max(arrives_ns, self._last_ns)
        self._sent += 1
        heapq.heappush(self._waiting, (arrives_ns, self._sent, thing))

    def arrived(self, now_ns: int) -> list[T]:
        """Take out what has arrived by now, in the order of arrival."""
        arrived = []
        while self._waiting and self._waiting[0][0] <= now_ns:
            arrived.append(heapq.heappop(self._waiting)[2])
        return arrived

    @property
    def next_ns(self) -> int | None:
        """When the next arrives; None where nothing is under way."""
        return self._waiting[0][0] if self._waiting else None
