"""The recording driver with the FR3's gripper: its orders, its loop, and fingers whose link goes on command."""

import threading
import time
from dataclasses import replace
from typing import Any

from common.geometry import Array
from common.host_clock import MonotonicClock
from remote_site.drivers.driver import Capabilities, GripperReading, JointCommand, RobotReading
from remote_site.drivers.franka.arm_memory import GripperMemory
from remote_site.drivers.franka.gripper_loop import GripperLoop, run_gripper_loop
from remote_site.drivers.franka.robot_port import GripperWidth, LinkLostError, UnreachableError
from remote_site.drivers.gripper_orders import GripperOrders
from remote_site.drivers.registry import DriverHost
from tests.faults.emulated_robot import OBJECT_M
from tests.faults.recording_driver import RecordingDriver

WIDEST_M = 0.08
MOVES_S = 0.5


class Fingers:
    """A `HandPort` with an object between its fingers; it wants to know nothing while it is `lost`."""

    def __init__(self) -> None:
        self.opening_m, self.lost = OBJECT_M, False

    def connected(self) -> "Fingers":
        if self.lost:
            raise UnreachableError("the gripper does not answer")
        return self

    def read(self) -> GripperWidth:
        if self.lost:
            raise LinkLostError("the gripper does not answer")
        return GripperWidth(self.opening_m, WIDEST_M)

    def open(self, width_m: float, speed_m_s: float) -> bool:  # noqa: ARG002  # as the protocol names it
        return self._go(width_m)

    def close(self, speed_m_s: float, force_n: float) -> bool:  # noqa: ARG002  # as the protocol names it
        return self._go(OBJECT_M)

    def _go(self, opening_m: float) -> bool:
        time.sleep(MOVES_S)
        self.opening_m = opening_m
        return True


class GrippingDriver(RecordingDriver):
    """The same with a gripper; commanded `gripper_lost`, its link is down until the command is False."""

    def __init__(self, host: DriverHost) -> None:
        super().__init__(host)
        self._fingers, self._memory, self._orders = Fingers(), GripperMemory(), GripperOrders()
        loop = GripperLoop(self._fingers.connected, self._memory, MonotonicClock(), 0.1, 25.0)
        arguments = (loop, MonotonicClock(), lambda: None)
        threading.Thread(target=run_gripper_loop, args=arguments, daemon=True).start()

    @property
    def capabilities(self) -> Capabilities:
        return replace(super().capabilities, gripper=True)

    def activate(self, q0: Array) -> None:
        self._withdraw()
        super().activate(q0)

    def read(self) -> RobotReading:
        opening_m = self._memory.opening_m
        return replace(super().read(), gripper=None if opening_m is None else GripperReading(opening_m, None))

    def write(self, command: JointCommand) -> JointCommand:
        order = self._orders.note(command.gripper, command.t_ns)
        if order is not None:
            self._memory.order(order)
        return super().write(command)

    def stop(self) -> None:
        self._withdraw()
        super().stop()

    def told(self, fields: dict[str, Any]) -> None:
        self._fingers.lost = fields.get("gripper_lost", self._fingers.lost)

    def _withdraw(self) -> None:
        if self._orders.withdraw():
            self._memory.withdraw()
