"""The emulated controller behind a serial line: bytes at the line's pace, some of them lost; over a pseudo-terminal."""

import os
import time
import tty
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

from common.clock import NS_PER_S, Clock
from common.process.service import ask_for_real_time
from remote_site.drivers.c500c.emulator import TICK_NS, EmulatedController
from remote_site.drivers.c500c.exchange import BITS_PER_BYTE
from remote_site.drivers.c500c.port import SerialPort
from remote_site.drivers.c500c.protocol import LARGEST_REQUEST, Parser

FIFO_PRIORITY = 40
POLL_S = 0.001


@dataclass
class EmulatedLine:
    """One direction of a serial line: a byte takes its time, and is lost with probability `loss`."""

    baud: int = 57600
    loss: float = 0.0
    rng: Random = field(default_factory=lambda: Random(1))  # noqa: S311  # which bytes are lost is no secret
    _bytes: deque[tuple[int, int]] = field(default_factory=deque)
    _free_ns: int = 0

    def push(self, data: bytes, now_ns: int) -> None:
        """Put bytes on the line."""
        for byte in data:
            self._free_ns = max(self._free_ns, now_ns) + NS_PER_S * BITS_PER_BYTE // self.baud
            if self.rng.random() >= self.loss:
                self._bytes.append((self._free_ns, byte))

    def pull(self, now_ns: int) -> bytes:
        """The bytes that have arrived at the other end."""
        out = bytearray()
        while self._bytes and self._bytes[0][0] <= now_ns:
            out.append(self._bytes.popleft()[1])
        return bytes(out)


class Emulation:
    """The controller with both directions of its line; `exchange` advances all of it to now."""

    def __init__(self, controller: EmulatedController, start_ns: int, *, loss: float = 0.0) -> None:
        self.controller = controller
        self.there, self.back = EmulatedLine(loss=loss), EmulatedLine(loss=loss)
        self._parser = Parser(LARGEST_REQUEST)
        self._ticked_ns = start_ns

    def exchange(self, data: bytes, now_ns: int) -> bytes:
        """Take bytes from the host; return those that have arrived at it by `now_ns`."""
        while self._ticked_ns + TICK_NS <= now_ns:
            self._ticked_ns += TICK_NS
            self.controller.receive(self._parser.feed(self.there.pull(self._ticked_ns)), self._ticked_ns)
            self.back.push(self.controller.tick(self._ticked_ns), self._ticked_ns)
        self.there.push(data, now_ns)
        return self.back.pull(now_ns)


class EmulatedPort:
    """A `Port` to an emulation in this process, on any clock."""

    def __init__(self, emulation: Emulation, clock: Clock) -> None:
        self._emulation, self._clock = emulation, clock

    def read(self) -> bytes:
        """The bytes received from the controller."""
        return self._emulation.exchange(b"", self._clock.now_ns())

    def write(self, data: bytes) -> None:
        """Bytes for the controller."""
        self._emulation.exchange(data, self._clock.now_ns())


@dataclass(frozen=True, slots=True)
class Terminal:
    """A pseudo-terminal: the controller's end, and the path at which the driver opens the other."""

    port: SerialPort
    path: str
    _kept: int  # an open far end, so that the terminal lives on between two drivers

    @classmethod
    def create(cls) -> "Terminal":
        """Open one, raw."""
        ours, theirs = os.openpty()
        tty.setraw(theirs)
        os.set_blocking(ours, False)
        return cls(SerialPort(ours), os.ttyname(theirs), theirs)


def run_emulation(
    emulation: Emulation, terminal: Terminal, should_stop: Callable[[], bool], beat: Callable[[], None]
) -> None:
    """Run the controller in real time in this process until `should_stop`, then until the arm rests."""
    port = terminal.port
    ask_for_real_time(FIFO_PRIORITY)
    while not (should_stop() and not emulation.controller.dq.any()):
        if should_stop():
            emulation.controller.halt()
        answers = emulation.exchange(port.read(), time.monotonic_ns())
        if answers:
            port.write(answers)
        beat()
        time.sleep(POLL_S)
