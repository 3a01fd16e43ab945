"""One question at a time over a line that may lose bytes: sent again until it is answered; pure."""

import struct
from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.port import Port
from remote_site.drivers.c500c.protocol import Flag, Frame, Kind, Parser, State

BITS_PER_BYTE = 10


@dataclass(slots=True)
class _Question:
    frame: Frame
    sent_ns: int


class Exchange:
    """What waits to be said, and the newest state heard at `heard_ns` (None before the first).

    A halt goes before an activation, an activation before a setpoint, and polls fill the pauses. Of setpoints that wait,
    only the newest is said.
    """

    def __init__(self, config: C500cConfig, port: Port) -> None:
        self._port = port
        self._parser = Parser()
        self._byte_ns = NS_PER_S * BITS_PER_BYTE / config.baud
        self._answer_ns = round(config.answer_ms * NS_PER_MS)
        self._pause_ns = round(NS_PER_S / (2 * config.rate_hz))
        self._sequence = 0
        self._asked: _Question | None = None
        self._waiting: dict[Kind, bytes] = {}
        self._polled_ns = 0
        self.repeats = 0
        self.state: State | None = None
        self.heard_ns: int | None = None

    def say(self, kind: Kind, payload: bytes = b"") -> None:
        """Have this said as soon as the line is free."""
        if kind is Kind.HALT:
            self._waiting.clear()
        self._waiting[kind] = payload

    def waits(self, kind: Kind) -> bool:
        """Whether this has not been answered yet."""
        return kind in self._waiting or (self._asked is not None and self._asked.frame.kind is kind)

    def pump(self, now_ns: int, *, room: bool) -> None:
        """Hear what has come, and say what is due; a setpoint only while there is `room` for it."""
        for frame in self._parser.feed(self._port.read()):
            self._hear(frame, now_ns)
        asked = self._asked
        if asked is None:
            self._ask_next(now_ns, room=room)
        elif now_ns - asked.sent_ns > self._answer_ns:
            self.repeats += 1
            if Kind.HALT in self._waiting:  # whatever it was, it must not come any more
                self._ask_next(now_ns, room=room)
            else:
                self._send(asked.frame, now_ns)

    def _hear(self, frame: Frame, now_ns: int) -> None:
        asked = self._asked
        if asked is None or frame.kind is not Kind.STATE or frame.sequence != asked.frame.sequence:
            return
        try:
            self.state = State.parse(frame.payload)
        except (struct.error, ValueError):
            return
        self.heard_ns = now_ns - round(len(frame.encoded) * self._byte_ns)
        self._asked = None

    def _ask_next(self, now_ns: int, *, room: bool) -> None:
        for kind in (Kind.HALT, Kind.ACTIVATE, Kind.SETPOINT):
            if kind in self._waiting and (room or kind is not Kind.SETPOINT):
                self._ask(kind, self._waiting.pop(kind), now_ns)
                return
        if now_ns - self._polled_ns >= self._pause_ns:
            self._polled_ns = now_ns
            self._ask(Kind.POLL, b"", now_ns)

    def _ask(self, kind: Kind, payload: bytes, now_ns: int) -> None:
        self._sequence = (self._sequence + 1) & 0xFF
        self._send(Frame(self._sequence, kind, payload), now_ns)

    def _send(self, frame: Frame, now_ns: int) -> None:
        self._asked = _Question(frame, now_ns)
        self._port.write(frame.encoded)


def is_up(state: State) -> bool:
    """The controller has power and no emergency stop is pressed."""
    return Flag.ARM_POWER in state.flags and Flag.EMERGENCY_STOP not in state.flags
