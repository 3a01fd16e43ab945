"""One direction of a network link, packet by packet: bottleneck with a queue, loss, delay and jitter; pure, seeded."""

from dataclasses import dataclass, field
from random import Random

from common.clock import NS_PER_MS
from lab.stage.network.in_transit import InTransit

LEAST_QUEUE_BYTES = 65536
JITTER_SIGMAS = 2.0  # standard deviations at which the jitter is cut off
FLOW = slice(12, 24)  # of an IPv4 packet without options: addresses and ports


@dataclass
class Impairment:
    """The effects of a link on packets, the same in both directions.

    The delay is one way, and varies by up to `jitter_ms` to either side: a normal distribution with half of that as its
    standard deviation, cut off there. The packets of a flow keep their order unless the link `reorders`. `loss` and
    `doubled` are fractions of packets, each drawn by itself. At `mbit_s` (0: as fast as it comes) packets wait in a
    queue of `queue_ms` or 64 kB, whichever is more; one that finds it full is dropped. While the link is `cut`
    nothing enters or leaves it.
    """

    delay_ms: float = 0.0
    jitter_ms: float = 0.0
    loss: float = 0.0
    doubled: float = 0.0
    reorders: bool = False
    mbit_s: float = 0.0
    queue_ms: float = 100.0
    cut: bool = False

    @property
    def queue_ns(self) -> float:
        """The longest wait in the queue."""
        return max(self.queue_ms * NS_PER_MS, LEAST_QUEUE_BYTES * 8e3 / self.mbit_s)


@dataclass
class LinkModel:
    """The packets in flight in one direction.

    A packet first passes the bottleneck, then it may be lost, then it travels: what is lost has taken its share of the
    rate. Packets already in flight keep their time of arrival when the impairment changes.
    """

    impairment: Impairment
    rng: Random
    _under_way: InTransit[tuple[int, bytes]] = field(default_factory=lambda: InTransit(in_order=False))
    _last_ns: dict[bytes, int] = field(default_factory=dict)
    _free_ns: int = 0

    def send(self, packet: bytes, now_ns: int) -> None:
        """A packet enters the link."""
        link, rng = self.impairment, self.rng
        if link.cut:
            return
        leaves_ns = now_ns
        if link.mbit_s:
            starts_ns = max(self._free_ns, now_ns)
            if starts_ns - now_ns > link.queue_ns:
                return
            leaves_ns = self._free_ns = starts_ns + round(len(packet) * 8e3 / link.mbit_s)
        if link.loss and rng.random() < link.loss:
            return
        for _ in range(2 if link.doubled and rng.random() < link.doubled else 1):
            self._travel(packet, leaves_ns + self._delay_ns())

    def arrived(self, now_ns: int) -> list[tuple[int, bytes]]:
        """The packets due by now in order, each with the time (ns) at which it was due."""
        due = self._under_way.arrived(now_ns)
        return [] if self.impairment.cut else due

    @property
    def due_ns(self) -> int | None:
        """The time when the next packet leaves the link; None without one."""
        return self._under_way.next_ns

    def _travel(self, packet: bytes, due_ns: int) -> None:
        if not self.impairment.reorders:
            flow = packet[FLOW]
            due_ns = self._last_ns[flow] = max(due_ns, self._last_ns.get(flow, 0))
        self._under_way.send((due_ns, packet), due_ns)

    def _delay_ns(self) -> int:
        link, off = self.impairment, 0.0
        if link.jitter_ms:
            off = self.rng.gauss(0.0, 1.0)
            while abs(off) > JITTER_SIGMAS:
                off = self.rng.gauss(0.0, 1.0)
        return round(max(0.0, link.delay_ms + link.jitter_ms * off / JITTER_SIGMAS) * NS_PER_MS)
