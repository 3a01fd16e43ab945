"""A link below TCP: carries IP packets between two TUN devices by its model; `python -m lab.stage.network.link_shim`.

Its arguments are the socket of its commands and the descriptors of both devices. A command is the fields of an
Impairment, or `report`: the path of a file to which it writes how many packets came and left, and how late they left.
"""

import json
import os
import select
import sys
import time
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

from common.clock import NS_PER_MS, NS_PER_S
from common.process.service import ask_for_real_time
from lab.stage.network.command_socket import CommandSocket
from lab.stage.network.link_model import Impairment, LinkModel

MTU = 2048
BATCH = 64  # packets read at once, so that neither direction waits for the other
IDLE_NS = NS_PER_S
FIFO_PRIORITY = 60
SEED = 6
LATE_NS = NS_PER_MS // 10  # resolution of the lateness


class Direction:
    """From a device to a device; counts what came and left, and how much later than the model wanted."""

    def __init__(self, source: int, sink: int, impairment: Impairment, seed: int) -> None:
        self.source, self._sink = source, sink
        self.model = LinkModel(impairment, Random(seed))  # noqa: S311  # which packets suffer is no secret
        self.came = 0
        self.late: Counter[int] = Counter()

    def take(self) -> None:
        """Read what waits at the device."""
        for _ in range(BATCH):
            try:
                packet = os.read(self.source, MTU)
            except BlockingIOError:
                return
            self.came += 1
            self.model.send(packet, time.monotonic_ns())

    def give(self) -> None:
        """Write what is due."""
        now_ns = time.monotonic_ns()
        for due_ns, packet in self.model.arrived(now_ns):
            os.write(self._sink, packet)
            self.late[(now_ns - due_ns) // LATE_NS] += 1

    def report(self) -> dict[str, float]:
        """The counts and percentiles since the last report; counting starts again."""
        left = self.late.total()
        figures = {"came": self.came, "left": left, **{f"late_p{p}_ms": self._late_ms(p) for p in (50, 99)}}
        self.came, self.late = 0, Counter()
        return figures

    def _late_ms(self, percentile: int) -> float:
        rank, passed = percentile / 100 * self.late.total(), 0
        for late in sorted(self.late):
            passed += self.late[late]
            if passed >= rank:
                return late * LATE_NS / NS_PER_MS
        return 0.0


def run(commands: CommandSocket, one: int, other: int) -> None:
    """Carry packets for ever, impaired as commanded."""
    impairment = Impairment()
    directions = Direction(one, other, impairment, SEED), Direction(other, one, impairment, SEED + 1)
    for device in (one, other):
        os.set_blocking(device, False)
    watched: list[Any] = [commands, one, other]
    while True:
        ready = select.select(watched, [], [], _wait_s(directions))[0]
        if commands in ready:
            _obey(commands.take(), impairment, directions)
        for direction in directions:
            if direction.source in ready:
                direction.take()
            direction.give()


def _wait_s(directions: tuple[Direction, ...]) -> float:
    now_ns = time.monotonic_ns()
    due_ns = min((d.model.due_ns for d in directions if d.model.due_ns is not None), default=now_ns + IDLE_NS)
    return max(due_ns - now_ns, 0) / NS_PER_S


def _obey(fields: dict[str, Any], impairment: Impairment, directions: tuple[Direction, ...]) -> None:
    if "report" in fields:
        path = Path(fields["report"])
        partial = path.with_suffix(".partial")
        partial.write_text(json.dumps([direction.report() for direction in directions]))
        partial.rename(path)
    else:
        vars(impairment).update(vars(Impairment()) | fields)


if __name__ == "__main__":
    ask_for_real_time(FIFO_PRIORITY)
    run(CommandSocket(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
