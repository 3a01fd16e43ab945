"""A bad network below TCP: carries IP packets between two TUN devices, late, lost, duplicated or cut off; seeded."""

import heapq
import os
import select
import sys
import time
from dataclasses import dataclass, field
from itertools import count
from random import Random
from typing import Any

from common.clock import NS_PER_MS, NS_PER_S
from common.process.service import ask_for_real_time
from tests.faults.command_socket import CommandSocket

MTU = 2048
QUEUE_NS = 300 * NS_PER_MS  # of a narrow link: what would wait longer is dropped
FIFO_PRIORITY = 60
SEED = 6


@dataclass
class Impairment:
    """One-way delay and jitter in ms (order is kept unless `reorders`), fractions of packets, and the link's rate."""

    delay_ms: float = 0.0
    jitter_ms: float = 0.0
    loss: float = 0.0
    doubled: float = 0.0
    reorders: bool = False
    mbit_s: float = 0.0
    cut: bool = False


@dataclass
class Direction:
    """One direction: from a device to a device, and the packets in flight."""

    source: int
    sink: int
    impairment: Impairment
    rng: Random
    _order: "count[int]" = field(default_factory=count)
    _waiting: list[tuple[int, int, bytes]] = field(default_factory=list)
    _last_ns: int = 0
    _free_ns: int = 0

    def take(self, now_ns: int) -> None:
        """A packet enters the link."""
        packet, link, rng = os.read(self.source, MTU), self.impairment, self.rng
        if link.cut or rng.random() < link.loss:
            return
        if link.mbit_s:
            self._free_ns = max(self._free_ns, now_ns)
            if self._free_ns - now_ns > QUEUE_NS:
                return
            self._free_ns += round(len(packet) * 8e3 / link.mbit_s)
        for _ in range(2 if rng.random() < link.doubled else 1):
            late_ns = round((link.delay_ms + rng.uniform(0, link.jitter_ms)) * NS_PER_MS)
            due_ns = (self._free_ns if link.mbit_s else now_ns) + late_ns
            due_ns = due_ns if link.reorders else max(due_ns, self._last_ns)
            self._last_ns = max(due_ns, self._last_ns)
            heapq.heappush(self._waiting, (due_ns, next(self._order), packet))

    def give(self, now_ns: int) -> None:
        """Packets that are due leave the link."""
        while self._waiting and self._waiting[0][0] <= now_ns:
            packet = heapq.heappop(self._waiting)[2]
            if not self.impairment.cut:
                os.write(self.sink, packet)

    @property
    def due_ns(self) -> int:
        """When the next packet leaves the link; a second from now without one."""
        return self._waiting[0][0] if self._waiting else time.monotonic_ns() + NS_PER_S


def run(commands: CommandSocket, one: int, other: int) -> None:
    """Carry packets for ever, impaired as commanded."""
    impairment = Impairment()
    rngs = Random(SEED), Random(SEED + 1)  # noqa: S311  # which packets suffer is no secret
    directions = [Direction(one, other, impairment, rngs[0]), Direction(other, one, impairment, rngs[1])]
    watched: list[Any] = [commands, one, other]
    while True:
        until_ns = min(direction.due_ns for direction in directions)
        wait_s = max(until_ns - time.monotonic_ns(), 0) / NS_PER_S
        ready = select.select(watched, [], [], wait_s)[0]
        if commands in ready:
            vars(impairment).update(vars(Impairment()) | commands.take())
        now_ns = time.monotonic_ns()
        for direction in directions:
            if direction.source in ready:
                direction.take(now_ns)
            direction.give(time.monotonic_ns())


if __name__ == "__main__":
    ask_for_real_time(FIFO_PRIORITY)
    run(CommandSocket(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
