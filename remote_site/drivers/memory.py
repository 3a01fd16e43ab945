"""What control and the driver's process share: orders one way, reports the other, and a bell; nobody ever waits."""

import mmap
import os
import select
from dataclasses import dataclass
from typing import Self

import numpy as np

from remote_site.drivers.driver import JointCommand
from remote_site.drivers.keeper import Order
from remote_site.shared_memory import Record, SharedRecord

ORDERS_KEPT = 64
FAULT_BYTES = 400
NATIVE_BYTES = 32


def order_dtype(joints: int) -> np.dtype[np.void]:
    """An `Order`, its command included."""
    return np.dtype(
        [
            ("activation", np.uint32),
            ("run", np.bool_),
            ("diversions", np.uint32),
            ("gripper_open", np.bool_),
            ("seq", np.uint64),
            ("t_ns", np.int64),
            ("motion", np.float64, (3, joints)),
        ]
    )


def report_dtype(joints: int) -> np.dtype[np.void]:
    """What the robot measured and what was last sent to it; `answered` is the last activation that was looked at.

    `code` is empty while the robot takes commands; `t_ns` is 0 before anything was measured, `force_n` NaN where no
    force is measured; `grip` is empty without a gripper.
    """
    return np.dtype(
        [
            ("at_ns", np.int64),
            ("answered", np.uint32),
            ("diversions", np.uint32),
            ("code", f"S{NATIVE_BYTES}"),
            ("native", f"S{NATIVE_BYTES}"),
            ("sentence", f"S{FAULT_BYTES}"),
            ("sent", np.float64, (3, joints)),
            ("t_ns", np.int64),
            ("has_obeyed", np.bool_),
            ("obeyed_seq", np.uint64),
            ("joints", np.float64, (2, joints)),
            ("grip", f"S{NATIVE_BYTES}"),
            ("opening_m", np.float64),
            ("force_n", np.float64),
            ("gripper_open", np.bool_),
        ]
    )


class OrderRing:
    """The newest 64 orders; the reader gets each of them once, unless it sleeps for longer than they are kept."""

    def __init__(self, joints: int) -> None:
        dtype = order_dtype(joints)
        self._record = SharedRecord(dtype, ORDERS_KEPT)
        self._scratch = np.zeros((), dtype=dtype)
        self._seen = self._record.count

    def write(self, order: Order) -> None:
        """Append an order; only control writes."""
        scratch, command = self._scratch, order.command
        scratch["activation"], scratch["run"], scratch["diversions"] = order.activation, order.run, order.diversions
        scratch["seq"], scratch["t_ns"], scratch["gripper_open"] = command.seq, command.t_ns, command.gripper_open
        motion = scratch["motion"]
        motion[0], motion[1], motion[2] = command.q, command.dq, command.ddq
        self._record.write(scratch)

    def take(self) -> list[Order]:
        """The orders written since the last call, oldest first; what was overwritten meanwhile is missing."""
        newest = self._record.count
        first = max(self._seen, newest - ORDERS_KEPT + 1) + 1
        self._seen = newest
        records = (self._record.at(count) for count in range(first, newest + 1))
        return [_order(record) for record in records if record is not None]


def _order(record: Record) -> Order:
    q, dq, ddq = record["motion"]
    command = JointCommand(int(record["seq"]), int(record["t_ns"]), q, dq, ddq, bool(record["gripper_open"]))
    return Order(int(record["activation"]), bool(record["run"]), int(record["diversions"]), command)


class Bell:
    """Wakes the driver's process as soon as an order has been written; ringing never waits."""

    def __init__(self) -> None:
        self._handle = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._poll = select.poll()
        self._poll.register(self._handle, select.POLLIN)

    def ring(self) -> None:
        """Wake the listener."""
        os.eventfd_write(self._handle, 1)

    def wait(self, timeout_ms: float) -> None:
        """Wait for a ring, at most so long."""
        if self._poll.poll(timeout_ms):
            os.eventfd_read(self._handle)


class BusyMark:
    """Since when a call of the driver is under way, in ns; 0 between calls."""

    def __init__(self) -> None:
        self._since_ns = np.frombuffer(mmap.mmap(-1, 8), dtype=np.int64)

    def set(self, since_ns: int) -> None:
        """Note the begin of a call, or its end by 0."""
        self._since_ns[0] = since_ns

    @property
    def since_ns(self) -> int:
        return int(self._since_ns[0])


@dataclass(frozen=True, slots=True)
class DriverMemory:
    """Everything control shares with the driver's process; made before both fork."""

    orders: OrderRing
    report: SharedRecord
    busy: BusyMark
    bell: Bell

    @classmethod
    def create(cls, joints: int) -> Self:
        """Empty memory for an arm of so many joints."""
        return cls(OrderRing(joints), SharedRecord(report_dtype(joints)), BusyMark(), Bell())
