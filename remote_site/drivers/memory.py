"""Memory shared by control and the driver's process: orders, reports and a bell; neither waits for the other."""

import mmap
import os
import select
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np

from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.faults import MOST_NATIVE, MOST_SENTENCE
from remote_site.drivers.supervisor.orders import DriverOrder
from remote_site.shared_record import Record, SharedRecord

ORDER_SLOTS = 64
MOTION_ROWS = 8
WORD = "S32"  # the longest code, bytes


def order_dtype(joints: int) -> np.dtype[np.void]:
    """The record of a `DriverOrder`, its `JointCommand` flattened; units as there."""
    numbers = [("activation", np.uint32), ("run", np.bool_), ("stop_count", np.uint32)]
    command = [("seq", np.uint64), ("t_ns", np.int64)]
    motion = [(name, np.float64, (joints,)) for name in ("q", "dq", "ddq")]
    return np.dtype([*numbers, *command, *motion, ("gripper", WORD)])


def report_dtype(joints: int) -> np.dtype[np.void]:
    """The record of a `DriverReport`, in the order of its fields."""
    times = [("at_ns", np.int64), ("activation", np.uint32), ("stop_count", np.uint32), ("onset_ns", np.int64)]
    robot = [("t_ns", np.int64), ("oldest_ns", np.int64), ("has_obeyed", np.bool_), ("obeyed_seq", np.uint64)]
    gripper = [("opening_m", np.float64), ("force_n", np.float64), ("gripper", WORD), ("grip", WORD)]
    fault = [("code", WORD), ("native", f"U{MOST_NATIVE}"), ("sentence", f"U{MOST_SENTENCE}")]
    written = [("written_seq", np.uint64), ("written_ns", np.int64)]
    return np.dtype([*times, *robot, *gripper, *fault, *written, ("motions", np.float64, (MOTION_ROWS, joints))])


class OrderRing:
    """The newest orders; the reader gets each of them once, unless it sleeps until they are overwritten."""

    def __init__(self, joints: int) -> None:
        self._record = SharedRecord(order_dtype(joints), ORDER_SLOTS)
        self._written = np.zeros((), self._record.dtype)
        self._seen = self._record.count

    def write(self, order: DriverOrder) -> None:
        """Append an order; only control writes."""
        c = order.command
        command = (c.seq, c.t_ns, c.q, c.dq, c.ddq, c.gripper.value.encode())
        self._written[()] = (order.activation, order.run, order.stop_count, *command)
        self._record.write(self._written)

    def take(self) -> list[DriverOrder]:
        """The orders written since the last call, oldest first; what was overwritten meanwhile is missing."""
        newest = self._record.count
        oldest = newest - ORDER_SLOTS + 2  # one slot less: the writer may be filling it
        first = max(self._seen + 1, oldest)
        self._seen = newest
        records = (self._record.read_number(number) for number in range(first, newest + 1))
        return [_order(record) for record in records if record is not None]


def _order(record: Record) -> DriverOrder:
    fields: Any = record.item()
    activation, run, stop_count, seq, t_ns, q, dq, ddq, gripper = fields
    command = JointCommand(seq, t_ns, q, dq, ddq, GripperCommand(gripper.decode()))
    return DriverOrder(activation, run, stop_count, command)


class DriverReport(NamedTuple):
    """The robot as measured, and what was last sent to it; `activation` is the last one that was handled.

    `at_ns` is when the report was written, `t_ns` when the robot was measured, both of the monotonic clock and 0 before
    the first time; `oldest_ns` is how old that may become. `obeyed_seq` is valid only if `has_obeyed`. A fault is
    `code`, the robot's own code `native` and `sentence`; `code` is empty while the robot takes commands. `opening_m`,
    `force_n` (NaN if it is not measured), `gripper` as commanded and the status `grip` describe the gripper; both are
    empty without one. The robot was given a motion last at `written_ns`, which comes from control's command
    `written_seq`; both are 0 before the first. `motions` (8, n), rad, rad/s, rad/s²: q and dq as measured, then q, dq,
    ddq as last commanded, or those at the onset of the stop in progress, then those that the robot was given last.
    `onset_ns` is the time of that onset, 0 without a stop.
    """

    at_ns: int
    activation: int
    stop_count: int
    onset_ns: int
    t_ns: int
    oldest_ns: int
    has_obeyed: bool
    obeyed_seq: int
    opening_m: float
    force_n: float
    gripper: bytes
    grip: bytes
    code: bytes
    native: str
    sentence: str
    written_seq: int
    written_ns: int
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
        """The newest report; DriverError when none is complete."""
        return DriverReport._make(self._record.read().item())


class Bell:
    """Wakes the driver's process as soon as an order has been written; ringing never waits."""

    def __init__(self) -> None:
        self._handle = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def ring(self) -> None:
        """Wake the listener."""
        os.eventfd_write(self._handle, 1)

    def wait(self, timeout_s: float) -> None:
        """Wait for a ring, at most `timeout_s`."""
        # select takes microseconds, poll only milliseconds.
        if select.select([self._handle], [], [], timeout_s)[0]:
            os.eventfd_read(self._handle)


class BusyMark:
    """The time when the driver's current call began, ns of the monotonic clock; 0 between calls."""

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
