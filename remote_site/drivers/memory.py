"""What control and the driver's process share: orders one way, reports the other, and a bell; nobody ever waits."""

import mmap
import os
import select
import struct
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from common.geometry import Array
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.supervisor.supervisor import DriverOrder
from remote_site.shared_record import SharedRecord

ORDERS_KEPT = 64
WORD_BYTES = 32
SENTENCE_BYTES = 400


ORDER = struct.Struct("<I?I?Qq")  # activation, run, diversions, gripper_open, seq, t_ns; then q, dq, ddq
REPORT = struct.Struct(f"<qIIqq?Qdd?{WORD_BYTES}s{WORD_BYTES}s{WORD_BYTES}s{SENTENCE_BYTES}s")
DOUBLES = np.dtype("<f8")


class OrderRing:
    """The newest 64 orders; the reader gets each of them once, unless it sleeps for longer than they are kept."""

    def __init__(self, joints: int) -> None:
        self._record = SharedRecord(np.dtype([("order", f"V{ORDER.size + 24 * joints}")]), ORDERS_KEPT)
        self._seen = self._record.count

    def write(self, order: DriverOrder) -> None:
        """Append an order; only control writes."""
        command = order.command
        head = ORDER.pack(
            order.activation, order.run, order.diversions, command.gripper_open, command.seq, command.t_ns
        )
        self._record.write_bytes(head + command.q.tobytes() + command.dq.tobytes() + command.ddq.tobytes())

    def take(self) -> list[DriverOrder]:
        """The orders written since the last call, oldest first; what was overwritten meanwhile is missing."""
        newest = self._record.count
        first = max(self._seen, newest - ORDERS_KEPT + 1) + 1
        self._seen = newest
        records = (self._record.at(count) for count in range(first, newest + 1))
        return [_order(data) for data in records if data is not None]


def _order(data: bytes) -> DriverOrder:
    activation, run, diversions, gripper_open, seq, t_ns = ORDER.unpack_from(data)
    q, dq, ddq = np.frombuffer(data, DOUBLES, offset=ORDER.size).reshape(3, -1)
    return DriverOrder(activation, run, diversions, JointCommand(seq, t_ns, q, dq, ddq, gripper_open))


class DriverReport(NamedTuple):
    """What the robot measured and what was last sent to it; `answered` is the last activation that was looked at.

    `at_ns` is when it was written, `t_ns` when it was measured, 0 before anything was. `obeyed_seq` counts if
    `has_obeyed`. `code` is empty while the robot takes commands, `grip` without a gripper, `force_n` NaN where no force
    is measured. `motions` (5, n): q and dq as measured, then q, dq, ddq as sent last, or at `onset_ns` when by a stop
    since then, 0 without one.
    """

    at_ns: int
    answered: int
    diversions: int
    onset_ns: int
    t_ns: int
    has_obeyed: bool
    obeyed_seq: int
    opening_m: float
    force_n: float
    gripper_open: bool
    grip: bytes
    code: bytes
    native: bytes
    sentence: bytes
    motions: Array


class ReportRecord:
    """The newest report."""

    def __init__(self, joints: int) -> None:
        self._record = SharedRecord(np.dtype([("report", f"V{REPORT.size + 40 * joints}")]))

    def write(self, report: DriverReport) -> None:
        """Publish a report; only the driver's process writes."""
        self._record.write_bytes(REPORT.pack(*report[:-1]) + report.motions.tobytes())

    def read(self) -> DriverReport:
        """The newest one."""
        data = self._record.read_bytes()
        motions = np.frombuffer(data, DOUBLES, offset=REPORT.size).reshape(5, -1)
        return DriverReport._make((*REPORT.unpack_from(data), motions))


class Bell:
    """Wakes the driver's process as soon as an order has been written; ringing never waits."""

    def __init__(self) -> None:
        self._handle = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def ring(self) -> None:
        """Wake the listener."""
        os.eventfd_write(self._handle, 1)

    def wait(self, timeout_s: float) -> None:
        """Wait for a ring, at most so long; to the microsecond, which poll cannot."""
        if select.select([self._handle], [], [], timeout_s)[0]:
            os.eventfd_read(self._handle)


class BusyMark:
    """Since when a call of the driver is under way, in ns; 0 between calls."""

    def __init__(self) -> None:
        self._since_ns = memoryview(mmap.mmap(-1, 8)).cast("q")

    def set(self, since_ns: int) -> None:
        """Note the begin of a call, or its end by 0."""
        self._since_ns[0] = since_ns

    @property
    def since_ns(self) -> int:
        return self._since_ns[0]


@dataclass(frozen=True, slots=True)
class DriverMemory:
    """Everything control shares with the driver's process; made before both fork."""

    orders: OrderRing
    report: ReportRecord
    busy: BusyMark
    bell: Bell

    @classmethod
    def create(cls, joints: int) -> Self:
        """Empty memory for an arm of so many joints."""
        return cls(OrderRing(joints), ReportRecord(joints), BusyMark(), Bell())
