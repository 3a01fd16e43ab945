"""One question at a time over a line that may lose bytes: sent again until it is answered; pure."""

import struct
from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import DriverError
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.port import Port
from remote_site.drivers.c500c.protocol import ControllerState, Flag, Kind, Parser, ProtocolFrame, Setpoint

BITS_PER_BYTE = 10
MOST_WAITING = 2
RETRY_NS = 8 * NS_PER_MS


@dataclass(slots=True)
class _Question:
    frame: ProtocolFrame
    sent_ns: int


class Exchange:
    """What waits to be said, and the newest state heard at `heard_ns` (None before the first).

    A halt goes before an activation, an activation before a setpoint, and polls fill the pauses. Setpoints keep their
    order, and none is left out: the arm would make two steps in the time of one.
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
        self._setpoints: deque[bytes] = deque()
        self._said_ns = self._retry_ns = 0
        self.repeats = 0
        self.state: ControllerState | None = None
        self.heard_ns: int | None = None

    def say(self, kind: Kind, payload: bytes = b"") -> None:
        """Have this said as soon as the line is free; DriverError when setpoints pile up."""
        if kind is not Kind.SETPOINT:
            self._setpoints.clear()
            self._waiting[kind] = payload
        elif len(self._setpoints) < MOST_WAITING:
            self._setpoints.append(payload)
        else:
            raise DriverError("the serial line does not keep up with the setpoints; check its noise and its speed")

    def waits(self, kind: Kind) -> bool:
        """Whether this has not been answered yet."""
        return kind in self._waiting or (self._asked is not None and self._asked.frame.kind is kind)

    def pump(self, now_ns: int) -> None:
        """Hear what has come, and say what is due."""
        for frame in self._parser.feed(self._port.read()):
            self._hear(frame, now_ns)
        asked = self._asked
        if asked is None:
            self._ask_next(now_ns)
        elif now_ns - asked.sent_ns > self._answer_ns:
            self.repeats += 1
            if Kind.HALT in self._waiting:  # whatever it was, it must not come any more
                self._ask_next(now_ns)
            else:
                self._send(asked.frame, now_ns)

    def _hear(self, frame: ProtocolFrame, now_ns: int) -> None:
        asked = self._asked
        if asked is None or frame.kind is not Kind.STATE or frame.sequence != asked.frame.sequence:
            return
        try:
            self.state = ControllerState.parse(frame.payload)
        except (struct.error, ValueError):
            return
        self.heard_ns = now_ns - round(len(frame.encoded) * self._byte_ns)
        self._asked = None
        if asked.frame.kind is Kind.SETPOINT and Flag.ACTIVE in self.state.flags:
            self._check_taken(asked.frame.payload, self.state.taken, now_ns)

    def _check_taken(self, payload: bytes, taken: int, now_ns: int) -> None:
        """Say a setpoint again, a little later, when the queue had no room for it."""
        if Setpoint.parse(payload).count != taken:
            self._setpoints.appendleft(payload)
            self._retry_ns = now_ns + RETRY_NS

    def _ask_next(self, now_ns: int) -> None:
        for kind in (Kind.HALT, Kind.ACTIVATE):
            if kind in self._waiting:
                self._ask(kind, self._waiting.pop(kind), now_ns)
                return
        if self._setpoints and now_ns >= self._retry_ns:
            self._ask(Kind.SETPOINT, self._setpoints.popleft(), now_ns)
        elif now_ns - self._said_ns >= self._pause_ns:
            self._ask(Kind.POLL, b"", now_ns)

    def _ask(self, kind: Kind, payload: bytes, now_ns: int) -> None:
        self._sequence = (self._sequence + 1) & 0xFF
        self._send(ProtocolFrame(self._sequence, kind, payload), now_ns)

    def _send(self, frame: ProtocolFrame, now_ns: int) -> None:
        self._asked, self._said_ns = _Question(frame, now_ns), now_ns
        self._port.write(frame.encoded)


def is_up(state: ControllerState) -> bool:
    """The controller has power and no emergency stop is pressed."""
    return Flag.ARM_POWER in state.flags and Flag.EMERGENCY_STOP not in state.flags
