"""The memory shared by control and the driver's process: orders, reports and a bell; neither waits for the other."""

import mmap
import os
import select
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np

from common.geometry import Array
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.supervisor.orders import DriverOrder
from remote_site.shared_record import Record, SharedRecord

ORDERS_KEPT = 64
WORD, SENTENCE = "S32", "S400"


def order_dtype(joints: int) -> np.dtype[np.void]:
    """A `DriverOrder` with its command's fields."""
    numbers = [("activation", np.uint32), ("run", np.bool_), ("stop_count", np.uint32)]
    command = [("seq", np.uint64), ("t_ns", np.int64)]
    motion = [(name, np.float64, (joints,)) for name in ("q", "dq", "ddq")]
    return np.dtype([*numbers, *command, *motion, ("gripper_open", np.bool_)])


def report_dtype(joints: int) -> np.dtype[np.void]:
    """A `DriverReport`."""
    times = [("at_ns", np.int64), ("answered", np.uint32), ("stop_count", np.uint32), ("onset_ns", np.int64)]
    robot = [("t_ns", np.int64), ("has_obeyed", np.bool_), ("obeyed_seq", np.uint64)]
    gripper = [("opening_m", np.float64), ("force_n", np.float64), ("gripper_open", np.bool_), ("grip", WORD)]
    fault = [("code", WORD), ("native", WORD), ("sentence", SENTENCE)]
    return np.dtype([*times, *robot, *gripper, *fault, ("motions", np.float64, (5, joints))])


class OrderRing:
    """The newest 64 orders; the reader gets each of them once, unless it sleeps for longer than they are kept."""

    def __init__(self, joints: int) -> None:
        self._record = SharedRecord(order_dtype(joints), ORDERS_KEPT)
        self._written = np.zeros((), self._record.dtype)
        self._seen = self._record.count

    def write(self, order: DriverOrder) -> None:
        """Append an order; only control writes."""
        c = order.command
        command = (c.seq, c.t_ns, c.q, c.dq, c.ddq, c.gripper_open)
        self._written[()] = (order.activation, order.run, order.stop_count, *command)
        self._record.write(self._written)

    def take(self) -> list[DriverOrder]:
        """The orders written since the last call, oldest first; what was overwritten meanwhile is missing."""
        newest = self._record.count
        first = max(self._seen, newest - ORDERS_KEPT + 1) + 1
        self._seen = newest
        records = (self._record.at(count) for count in range(first, newest + 1))
        return [_order(record) for record in records if record is not None]


def _order(record: Record) -> DriverOrder:
    fields: Any = record.item()
    activation, run, stop_count, *command = fields
    return DriverOrder(activation, run, stop_count, JointCommand(*command))


class DriverReport(NamedTuple):
    """What the robot measured and what was last sent to it; `answered` is the last activation that was handled.

    `at_ns` is when it was written, `t_ns` when it was measured, 0 before anything was. `obeyed_seq` is valid if
    `has_obeyed`. `code` is empty while the robot takes commands, `grip` without a gripper, `force_n` NaN where no force
    is measured. `motions` (5, n): q and dq as measured, then q, dq, ddq as commanded last, or at `onset_ns` of the stop
    that has begun since; that is 0 without one.
    """

    at_ns: int
    answered: int
    stop_count: int
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
        self._record = SharedRecord(report_dtype(joints))
        self._written = np.zeros((), self._record.dtype)

    def write(self, report: DriverReport) -> None:
        """Publish a report; only the driver's process writes."""
        self._written[()] = report
        self._record.write(self._written)

    def read(self) -> DriverReport:
        """The newest one."""
        return DriverReport._make(self._record.read().item())


class Bell:
    """Wakes the driver's process as soon as an order has been written; ringing never waits."""

    def __init__(self) -> None:
        self._handle = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def ring(self) -> None:
        """Wake the listener."""
        os.eventfd_write(self._handle, 1)

    def wait(self, timeout_s: float) -> None:
        """Wait for a ring, at most `timeout_s`; to the microsecond, which poll cannot."""
        if select.select([self._handle], [], [], timeout_s)[0]:
            os.eventfd_read(self._handle)


class BusyMark:
    """When the driver call under way began, in ns; 0 between calls."""

    def __init__(self) -> None:
        self._since_ns = memoryview(mmap.mmap(-1, 8)).cast("q")

    def set(self, since_ns: int) -> None:
        """Note the start of a call, or its end by 0."""
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
        """Empty memory for an arm of this many joints."""
        return cls(OrderRing(joints), ReportRecord(joints), BusyMark(), Bell())
