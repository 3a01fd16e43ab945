"""One request at a time over a line that may lose bytes: sent again until it is answered; pure."""

import struct
from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import DriverError
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.port import Port
from remote_site.drivers.c500c.protocol import (
    LARGEST_ANSWER,
    ControllerState,
    Flag,
    Kind,
    Parser,
    ProtocolFrame,
    Setpoint,
)

BITS_PER_BYTE = 10
MOST_WAITING = 2
RETRY_NS = 8 * NS_PER_MS


@dataclass(slots=True)
class _Request:
    frame: ProtocolFrame
    sent_ns: int


class TransmitQueue:
    """The queue for the line: a halt goes before an activation, an activation before the setpoints in their order.

    No setpoint is left out: the arm would make two steps in the time of one. But none outlives a halt or an activation:
    it would move the arm and its gripper as was commanded before.
    """

    def __init__(self) -> None:
        self._urgent: dict[Kind, bytes] = {}
        self._setpoints: deque[bytes] = deque()
        self._retry_ns = 0

    def __contains__(self, kind: Kind) -> bool:
        """Return whether a halt or an activation waits."""
        return kind in self._urgent

    def append(self, kind: Kind, payload: bytes) -> None:
        """Queue a message; a halt drops all others, an activation the setpoints. DriverError when setpoints pile up."""
        if kind is not Kind.SETPOINT:
            self._setpoints.clear()
            if kind is Kind.HALT:
                self._urgent.clear()
            self._urgent[kind] = payload
        elif len(self._setpoints) < MOST_WAITING:
            self._setpoints.append(payload)
        else:
            raise DriverError("the serial line does not keep up with the setpoints; check its noise and its speed")

    def put_back(self, payload: bytes, now_ns: int) -> None:
        """Send a setpoint again, a little later: the controller had no room for it."""
        if self._urgent:
            return
        self._setpoints.appendleft(payload)
        self._retry_ns = now_ns + RETRY_NS

    def pop(self, now_ns: int) -> tuple[Kind, bytes] | None:
        """The next message that may be sent, None without one."""
        for kind in (Kind.HALT, Kind.ACTIVATE):
            if kind in self._urgent:
                return kind, self._urgent.pop(kind)
        if self._setpoints and now_ns >= self._retry_ns:
            return Kind.SETPOINT, self._setpoints.popleft()
        return None


class Exchange:
    """Sends what is queued, fills the pauses with polls, and keeps the newest state.

    To be read: `state`, received at `received_ns` (both None before the first), and `repeats`, the requests that were
    sent again.
    """

    def __init__(self, config: C500cConfig, port: Port) -> None:
        self._port = port
        self._parser = Parser(LARGEST_ANSWER)
        self._queue = TransmitQueue()
        self._byte_ns = NS_PER_S * BITS_PER_BYTE / config.baud
        self._answer_ns = round(config.answer_ms * NS_PER_MS)
        self._pause_ns = round(NS_PER_S / (2 * config.rate_hz))
        self._sequence = self._sent_ns = 0
        self._pending: _Request | None = None
        self.repeats = 0
        self.state: ControllerState | None = None
        self.received_ns: int | None = None

    def send(self, kind: Kind, payload: bytes = b"") -> None:
        """Send this as soon as the line is free; DriverError when setpoints pile up."""
        self._queue.append(kind, payload)

    def is_pending(self, kind: Kind) -> bool:
        """Return whether this has not been answered yet."""
        return kind in self._queue or (self._pending is not None and self._pending.frame.kind == kind)

    def pump(self, now_ns: int) -> None:
        """Take what has been received, and send what is due."""
        for frame in self._parser.feed(self._port.read()):
            self._receive(frame, now_ns)
        pending = self._pending
        if pending is None:
            self._send_next(now_ns)
        elif now_ns - pending.sent_ns > self._answer_ns:
            self.repeats += 1
            if Kind.HALT in self._queue:  # the pending request must not be sent again, whatever it was
                self._send_next(now_ns)
            else:
                self._write(pending.frame, now_ns)

    def _receive(self, frame: ProtocolFrame, now_ns: int) -> None:
        pending = self._pending
        if pending is None or frame.kind != Kind.STATE or frame.sequence != pending.frame.sequence:
            return
        try:
            self.state = ControllerState.parse(frame.payload)
        except (struct.error, ValueError):
            return
        self.received_ns = now_ns - round(len(frame.encoded) * self._byte_ns)
        self._pending = None
        setpoint = pending.frame.kind == Kind.SETPOINT and Flag.ACTIVE in self.state.flags
        if setpoint and Setpoint.parse(pending.frame.payload).count != self.state.taken:
            self._queue.put_back(pending.frame.payload, now_ns)

    def _send_next(self, now_ns: int) -> None:
        message = self._queue.pop(now_ns)
        if message is None and now_ns - self._sent_ns >= self._pause_ns:
            message = Kind.POLL, b""
        if message is not None:
            self._sequence = (self._sequence + 1) & 0xFF
            self._write(ProtocolFrame(self._sequence, *message), now_ns)

    def _write(self, frame: ProtocolFrame, now_ns: int) -> None:
        self._pending, self._sent_ns = _Request(frame, now_ns), now_ns
        self._port.write(frame.encoded)


def is_up(state: ControllerState) -> bool:
    """The controller has power and no emergency stop is pressed."""
    return Flag.ARM_POWER in state.flags and Flag.EMERGENCY_STOP not in state.flags
