"""The server protocol of the A465's controller: frames with checksum and sequence, built and taken apart; pure.

A frame is `A5 length sequence kind payload crc`: one byte each, `length` of the payload, and CRC-16-CCITT of all
between the start byte and the checksum, low byte first. Angles travel as signed 32-bit microradians, little-endian.
"""

import binascii
import struct
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Self

from common.messages.robot import GripperCommand

START = 0xA5
HEAD_BYTES, CRC_BYTES = 4, 2
JOINTS = 6
RAD = 1e-6


class Kind(IntEnum):
    """The kinds of frame: what the host asks, and the controller's one answer."""

    POLL = 1
    ACTIVATE = 2
    SETPOINT = 3
    HALT = 4
    STATE = 16


class Flag(IntFlag):
    """The controller's condition."""

    ACTIVE = 1
    MOVING = 2
    ARM_POWER = 4
    EMERGENCY_STOP = 8
    GRIPPER_BUSY = 16


class Fault(IntEnum):
    """The reasons why the controller takes no setpoints."""

    NONE = 0
    WATCHDOG = 1
    UNDERRUN = 2
    APART = 3
    BLOCKED = 4
    EMERGENCY_STOP = 5
    ARM_POWER = 6


@dataclass(frozen=True, slots=True)
class ProtocolFrame:
    """One message, of a `Kind` or of one that is not known; the answer to a frame carries its sequence."""

    sequence: int
    kind: int
    payload: bytes = b""

    @property
    def encoded(self) -> bytes:
        """The bytes on the line."""
        body = bytes((len(self.payload), self.sequence, self.kind)) + self.payload
        return bytes((START,)) + body + _crc(body)


class Parser:
    """Finds frames in the bytes from a line that may lose or change some.

    A length of more than `largest_payload` is none, so one wrong bit never keeps it waiting for long.
    """

    def __init__(self, largest_payload: int) -> None:
        self._largest_payload = largest_payload
        self._buffer = bytearray()
        self.damaged = 0

    def feed(self, data: bytes) -> list[ProtocolFrame]:
        """The frames that are complete now; a start byte that begins none is skipped and counted."""
        self._buffer += data
        frames: list[ProtocolFrame] = []
        while (begin := self._buffer.find(START)) >= 0:
            del self._buffer[:begin]
            frame = self._first()
            if frame is None:
                return frames
            frames += frame
        self._buffer.clear()
        return frames

    def _first(self) -> list[ProtocolFrame] | None:
        """The frame at the buffer's start, [] when there is none after all, None while it is not complete."""
        buffer = self._buffer
        if len(buffer) < HEAD_BYTES:
            return None
        length = buffer[1]
        end = HEAD_BYTES + length + CRC_BYTES
        if length <= self._largest_payload and len(buffer) < end:
            return None
        body, crc = bytes(buffer[1 : end - CRC_BYTES]), bytes(buffer[end - CRC_BYTES : end])
        if length > self._largest_payload or _crc(body) != crc:
            self.damaged += 1
            del buffer[:1]
            return []
        del buffer[:end]
        return [ProtocolFrame(body[1], body[2], body[3:])]


GRIPPER_COMMANDS = (GripperCommand.KEEP, GripperCommand.OPEN, GripperCommand.CLOSED)  # by their byte on the line


@dataclass(frozen=True, slots=True)
class Setpoint:
    """Joints in rad, to be reached a period after the last setpoint, and the gripper's command, at a fraction of force.

    `count` rises by one each new setpoint, so that one sent again is not queued twice.
    """

    count: int
    joints: tuple[float, ...]
    gripper: GripperCommand
    grip_percent: int

    FORMAT = struct.Struct(f"<H{JOINTS}iBB")

    @property
    def payload(self) -> bytes:
        """The bytes of the payload."""
        joints = (round(angle / RAD) for angle in self.joints)
        return self.FORMAT.pack(self.count & 0xFFFF, *joints, GRIPPER_COMMANDS.index(self.gripper), self.grip_percent)

    @classmethod
    def parse(cls, payload: bytes) -> Self:
        """Parse a payload; struct.error when it has another length, ValueError at no command of the gripper."""
        count, *joints, gripper, percent = cls.FORMAT.unpack(payload)
        if gripper >= len(GRIPPER_COMMANDS):
            raise ValueError(f"{gripper} is no command of the gripper; give 0 to keep, 1 to open or 2 to close it")
        return cls(count, tuple(angle * RAD for angle in joints), GRIPPER_COMMANDS[gripper], percent)


@dataclass(frozen=True, slots=True)
class Activation:
    """The place where the arm is assumed, rad, and the period of setpoints to come, ms; `count` as in `Setpoint`."""

    count: int
    joints: tuple[float, ...]
    period_ms: int

    FORMAT = struct.Struct(f"<H{JOINTS}iH")

    @property
    def payload(self) -> bytes:
        """The bytes of the payload."""
        joints = (round(angle / RAD) for angle in self.joints)
        return self.FORMAT.pack(self.count & 0xFFFF, *joints, self.period_ms)

    @classmethod
    def parse(cls, payload: bytes) -> Self:
        """Parse a payload; struct.error when it has another length."""
        count, *joints, period_ms = cls.FORMAT.unpack(payload)
        return cls(count, tuple(angle * RAD for angle in joints), period_ms)


@dataclass(frozen=True, slots=True)
class ControllerState:
    """The controller's answer to every frame.

    `begun` is the count of the setpoint that the arm now moves to, `taken` of the last one that found room in the
    queue, `queued` how many wait; joints in rad, the gripper's opening in m.
    """

    flags: Flag
    fault: Fault
    queued: int
    activation: int
    begun: int
    taken: int
    opening_m: float
    joints: tuple[float, ...]

    FORMAT = struct.Struct(f"<BBBHHHH{JOINTS}i")

    @property
    def payload(self) -> bytes:
        """The bytes of the payload."""
        joints = (round(angle / RAD) for angle in self.joints)
        opening = round(self.opening_m * 1e5)
        counts = (count & 0xFFFF for count in (self.activation, self.begun, self.taken))
        return self.FORMAT.pack(self.flags, self.fault, self.queued, *counts, opening, *joints)

    @classmethod
    def parse(cls, payload: bytes) -> Self:
        """Parse a payload; struct.error or ValueError when it is not a state."""
        flags, fault, queued, activation, begun, taken, opening, *joints = cls.FORMAT.unpack(payload)
        angles = tuple(angle * RAD for angle in joints)
        return cls(Flag(flags), Fault(fault), queued, activation, begun, taken, opening * 1e-5, angles)


LARGEST_REQUEST = max(Activation.FORMAT.size, Setpoint.FORMAT.size)
LARGEST_ANSWER = ControllerState.FORMAT.size


def _crc(body: bytes) -> bytes:
    return binascii.crc_hqx(body, 0xFFFF).to_bytes(CRC_BYTES, "little")
