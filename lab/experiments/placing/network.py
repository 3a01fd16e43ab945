"""A network between both sites on stepped time: messages that may be lost, and a stream in which none is."""

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from lab.stage.network.in_transit import InTransit

T = TypeVar("T")
PACKET_BYTES = 1200
BUFFER_BYTES, BUFFER_NS = 64_000, 100 * NS_PER_MS  # what may wait to be sent, whichever is more
AGAIN_NS = 10 * NS_PER_MS  # and a round trip, until a lost packet is sent again


@dataclass(frozen=True, slots=True)
class Network:
    """The same in both directions: delay one way, the fraction of packets that are lost, the rate (None: no bound)."""

    delay_ms: float = 0.0
    loss: float = 0.0
    mbit_s: float | None = None

    @property
    def delay_ns(self) -> int:
        """The delay one way."""
        return round(self.delay_ms * NS_PER_MS)

    def sending_ns(self, size: int) -> int:
        """Compute how long so many bytes take to leave, ns."""
        return round(size * 8 * NS_PER_S / (self.mbit_s * 1e6)) if self.mbit_s is not None else 0


class Messages(Generic[T]):
    """One direction of best-effort messages of a packet each; `own_ns` is what each takes beside the network,
    `takes_ns` in all.

    They are too small to take part in the rate. `newest` is the last that arrived, None before the first.
    """

    def __init__(self, network: Network, rng: np.random.Generator, own_ns: int = 0) -> None:
        self._loss, self.takes_ns, self._rng = network.loss, own_ns + network.delay_ns, rng
        self._under_way = InTransit[T]()
        self.newest: T | None = None

    def send(self, message: T, now_ns: int) -> None:
        """A message leaves now, and may be lost."""
        if self._rng.random() >= self._loss:
            self._under_way.send(message, now_ns + self.takes_ns)

    def arrived(self, now_ns: int) -> list[T]:
        """Take out what has arrived by now, oldest first."""
        arrived = self._under_way.arrived(now_ns)
        self.newest = arrived[-1] if arrived else self.newest
        return arrived


class Stream(Generic[T]):
    """One direction of a stream such as TCP's, with a congestion control that knows the link.

    Packets leave at the link's rate; a lost one is sent again a round trip later, and all behind it wait for it. What
    finds the send buffer full is dropped by its sender, as pictures are. `own_ns` is what each message takes beside.
    """

    def __init__(self, network: Network, rng: np.random.Generator, own_ns: int = 0) -> None:
        self._network, self._rng, self._own_ns = network, rng, own_ns
        self._buffer_ns = max(BUFFER_NS, network.sending_ns(BUFFER_BYTES))
        self._free_ns = self._last_ns = 0
        self._under_way = InTransit[T]()

    def send(self, message: T, size: int, now_ns: int) -> None:
        """Send a message of so many bytes."""
        starts_ns = max(self._free_ns, now_ns)
        if starts_ns - now_ns > self._buffer_ns:
            return
        self._free_ns = starts_ns
        for _ in range(-(-size // PACKET_BYTES)):
            self._last_ns = max(self._last_ns, self._packet_comes_ns())
        self._under_way.send(message, self._last_ns + self._own_ns)

    def arrived(self, now_ns: int) -> list[T]:
        """Take out what has arrived by now, oldest first."""
        return self._under_way.arrived(now_ns)

    def _packet_comes_ns(self) -> int:
        """Send one packet, as often as it takes; when it has come."""
        network, tries = self._network, 1
        while self._rng.random() < network.loss:
            tries += 1
        self._free_ns += tries * network.sending_ns(PACKET_BYTES)
        return self._free_ns + network.delay_ns + (tries - 1) * (2 * network.delay_ns + AGAIN_NS)
