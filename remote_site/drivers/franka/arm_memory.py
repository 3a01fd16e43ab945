"""Memory that the driver shares with the processes of its arm and its gripper: orders there, and what they report."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.faults import MOST_NATIVE, MOST_SENTENCE, FaultCode, RobotFault
from remote_site.drivers.franka.robot_limits import JOINTS
from remote_site.drivers.gripper_orders import GripperOrder
from remote_site.drivers.memory import WORD, OrderRing
from remote_site.shared_record import SharedRecord

ARM_STATUS = np.dtype(
    [
        ("t_ns", np.int64),
        ("activation", np.uint32),
        ("active", np.bool_),
        ("has_obeyed", np.bool_),
        ("obeyed_seq", np.uint64),
        ("q", np.float64, (JOINTS,)),
        ("dq", np.float64, (JOINTS,)),
        ("code", WORD),
        ("native", f"U{MOST_NATIVE}"),
        ("sentence", f"U{MOST_SENTENCE}"),
    ]
)
HAND_ORDER = np.dtype([("count", np.uint32), ("gripper", WORD), ("until_ns", np.int64)])
HAND_STATUS = np.dtype([("done", np.uint32), ("opening_m", np.float64)])


@dataclass(frozen=True, slots=True)
class ArmStatus:
    """The arm as last measured at `t_ns` by the host's clock, 0 before: joints (7,) in rad and rad/s.

    `activation` is the last one that was handled, `active` whether its motion takes setpoints, `obeyed_seq` the one
    that is gone to; `fault` is why it takes none.
    """

    t_ns: int
    activation: int
    active: bool
    obeyed_seq: int | None
    q: Array
    dq: Array
    fault: RobotFault | None


class ArmMemory:
    """Orders of the driver to the arm's process, and its status."""

    def __init__(self) -> None:
        self.orders = OrderRing(JOINTS)
        self._status = SharedRecord(ARM_STATUS)
        self._written = np.zeros((), ARM_STATUS)

    def report(self, status: ArmStatus) -> None:
        """Publish the status; only the arm's process does."""
        fault, obeyed = status.fault, status.obeyed_seq
        words = (fault.code.value.encode(), fault.native, fault.sentence) if fault is not None else (b"", "", "")
        motion = (obeyed is not None, obeyed or 0, status.q, status.dq)
        self._written[()] = (status.t_ns, status.activation, status.active, *motion, *words)
        self._status.write(self._written)

    @property
    def status(self) -> ArmStatus:
        """The newest status."""
        fields: Any = self._status.read().item()
        t_ns, activation, active, has_obeyed, obeyed, q, dq, code, native, sentence = fields
        fault = RobotFault(FaultCode(code.decode()), sentence, native) if code else None
        return ArmStatus(t_ns, activation, active, obeyed if has_obeyed else None, np.array(q), np.array(dq), fault)


@dataclass
class GripperMemory:
    """Orders of the driver to the gripper's process, numbered, and which of them is done with which opening."""

    _orders: SharedRecord = field(default_factory=lambda: SharedRecord(HAND_ORDER))
    _status: SharedRecord = field(default_factory=lambda: SharedRecord(HAND_STATUS))
    _count: int = 0  # of the driver's orders

    def __post_init__(self) -> None:
        self.report(0, math.nan)

    def order(self, order: GripperOrder) -> None:
        """Order the gripper to open or close; only the driver does."""
        self._count += 1
        self._write(order)

    def withdraw(self) -> None:
        """Order nothing in the place of the last order, which counts as done; only the driver does."""
        self._write(GripperOrder(GripperCommand.KEEP, 0))

    def ordered(self) -> tuple[int, GripperOrder]:
        """The newest order and its number; number 0 before the first, KEEP where it was withdrawn."""
        fields: Any = self._orders.read().item()
        count, gripper, until_ns = fields
        return count, GripperOrder(GripperCommand(gripper.decode()) if count else GripperCommand.KEEP, until_ns)

    def report(self, done: int, opening_m: float) -> None:
        """Publish which order is done, and the opening, NaN without one; only the gripper's process does."""
        self._status.write(np.array((done, opening_m), HAND_STATUS))

    @property
    def opening_m(self) -> float | None:
        """The opening, None while the driver's last order is not done or nothing is measured."""
        fields: Any = self._status.read().item()
        done, opening_m = fields
        return None if done != self._count or math.isnan(opening_m) else float(opening_m)

    def _write(self, order: GripperOrder) -> None:
        self._orders.write(np.array((self._count, order.gripper.value.encode(), order.until_ns), HAND_ORDER))
