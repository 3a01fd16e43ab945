"""A bad network below TCP: carries IP packets between two TUN devices, late, lost, doubled or cut off; seeded."""

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
from tests.faults.puppets import Ear

MTU = 2048
QUEUE_NS = 300 * NS_PER_MS  # of a narrow link: what would wait longer is dropped
FIFO_PRIORITY = 60
SEED = 6


@dataclass
class Weather:
    """What the link does: one way delay and jitter in ms (order is kept unless `reorders`), shares of packets, rate."""

    delay_ms: float = 0.0
    jitter_ms: float = 0.0
    loss: float = 0.0
    doubled: float = 0.0
    reorders: bool = False
    mbit_s: float = 0.0
    cut: bool = False


@dataclass
class Way:
    """One direction: from a device, to a device, and what is under way."""

    source: int
    sink: int
    weather: Weather
    luck: Random
    _order: count = field(default_factory=count)
    _waiting: list[tuple[int, int, bytes]] = field(default_factory=list)
    _last_ns: int = 0
    _free_ns: int = 0

    def take(self, now_ns: int) -> None:
        """A packet enters the link."""
        packet, weather, luck = os.read(self.source, MTU), self.weather, self.luck
        if weather.cut or luck.random() < weather.loss:
            return
        if weather.mbit_s:
            self._free_ns = max(self._free_ns, now_ns)
            if self._free_ns - now_ns > QUEUE_NS:
                return
            self._free_ns += round(len(packet) * 8e3 / weather.mbit_s)
        for _ in range(2 if luck.random() < weather.doubled else 1):
            late_ns = round((weather.delay_ms + luck.uniform(0, weather.jitter_ms)) * NS_PER_MS)
            due_ns = (self._free_ns if weather.mbit_s else now_ns) + late_ns
            due_ns = due_ns if weather.reorders else max(due_ns, self._last_ns)
            self._last_ns = max(due_ns, self._last_ns)
            heapq.heappush(self._waiting, (due_ns, next(self._order), packet))

    def give(self, now_ns: int) -> None:
        """Whatever has come through leaves the link."""
        while self._waiting and self._waiting[0][0] <= now_ns:
            packet = heapq.heappop(self._waiting)[2]
            if not self.weather.cut:
                os.write(self.sink, packet)

    @property
    def due_ns(self) -> int:
        """When the next packet comes through; far in the future without one."""
        return self._waiting[0][0] if self._waiting else time.monotonic_ns() + NS_PER_S


def run(ear: Ear, one: int, other: int) -> None:
    """Carry packets for ever, in the weather that is told."""
    weather = Weather()
    lucks = Random(SEED), Random(SEED + 1)  # noqa: S311  # which packets suffer is no secret
    ways = [Way(one, other, weather, lucks[0]), Way(other, one, weather, lucks[1])]
    while True:
        until_ns = min(way.due_ns for way in ways)
        wait_s = max(until_ns - time.monotonic_ns(), 0) / NS_PER_S
        ready: list[Any] = select.select([ear, one, other], [], [], wait_s)[0]
        if ear in ready:
            weather.__dict__.update(Weather().__dict__ | ear.take())
        now_ns = time.monotonic_ns()
        for way in ways:
            if way.source in ready:
                way.take(now_ns)
            way.give(time.monotonic_ns())


if __name__ == "__main__":
    ask_for_real_time(FIFO_PRIORITY)
    run(Ear(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
