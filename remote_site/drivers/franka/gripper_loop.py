"""The gripper's process: opens and closes as the driver orders, and measures in between."""

import math
from collections.abc import Callable
from typing import NoReturn

import structlog

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.messages.robot import GripperCommand
from remote_site.drivers.franka.arm_memory import GripperMemory
from remote_site.drivers.franka.robot_port import GripperPort, LinkLostError, RobotRefusedError
from remote_site.drivers.gripper_orders import GripperOrder

PAUSE_NS = 10 * NS_PER_MS
AGAIN_NS = NS_PER_S
HOMED_M = 0.01  # a gripper that was not homed since its start reports a width of 0


class GripperLoop:
    """Connects and measures; each turn measures, and then does the newest order, if there is one.

    So the link is known to be up when an order goes out. What was ordered before there was a link, or before it was
    lost, is done no more. The maker's client waits while the fingers move, so nothing is measured meanwhile. A gripper
    that fails stops no arm: what it fails at is logged, and its opening shows the rest.
    """

    def __init__(
        self, connect: Callable[[], GripperPort], memory: GripperMemory, clock: Clock, speed_m_s: float, force_n: float
    ) -> None:
        self._connect, self._memory, self._clock = connect, memory, clock
        self._speed_m_s, self._force_n = speed_m_s, force_n
        self._port: GripperPort | None = None
        self._told = False  # that there is no link
        self._done = 0
        self._widest_m = 0.0
        self._log = structlog.get_logger()

    def turn(self) -> None:
        """Measure, then do what is ordered."""
        try:
            port = self._connected()
            state = port.read()
            self._widest_m = state.widest_m
            self._memory.report(self._done, state.opening_m)
            count, order = self._memory.ordered()
            if count != self._done:
                self._obey(port, order)
                self._done = count
        except LinkLostError as error:
            if self._port is not None or not self._told:
                cure = "without a Franka Hand set driver.options.gripper = false"
                self._log.warning("no link to the gripper", reason=str(error), cure=cure)
            self._port, self._told = None, True
            self._withdraw()
            self._memory.report(self._done, math.nan)
            self._clock.sleep_until_ns(self._clock.now_ns() + AGAIN_NS)

    def _connected(self) -> GripperPort:
        """The gripper; of a new link what was ordered without it is withdrawn."""
        if self._port is None:
            self._port = self._connect()
            self._withdraw()
        return self._port

    def _withdraw(self) -> None:
        count, order = self._memory.ordered()
        if count != self._done and order.gripper is not GripperCommand.KEEP:
            self._log.warning("the gripper has no link, and will not do what was ordered", ordered=order.gripper.value)
        self._done = count

    def _obey(self, port: GripperPort, order: GripperOrder) -> None:
        if order.gripper is GripperCommand.KEEP:
            return
        if self._clock.now_ns() > order.until_ns:
            self._log.warning("the gripper was ordered too long ago, and keeps", ordered=order.gripper.value)
            return
        try:
            done = self._move(port, order.gripper)
        except LinkLostError:
            raise
        except DriverError as error:
            self._log.warning("the gripper refuses", said=str(error), cure="home it in Desk")
        else:
            if not done:
                self._log.warning("the gripper did not end where it was sent", ordered=order.gripper.value)

    def _move(self, port: GripperPort, gripper: GripperCommand) -> bool:
        if gripper is GripperCommand.CLOSED:
            return port.close(self._speed_m_s, self._force_n)
        if self._widest_m < HOMED_M:
            raise RobotRefusedError("it has not been homed, and does not know how wide it opens")
        return port.open(self._widest_m, self._speed_m_s)


def run_gripper_loop(loop: GripperLoop, clock: Clock, beat: Callable[[], None]) -> NoReturn:
    """Turn until this process is ended; what the gripper holds stays held."""
    while True:
        loop.turn()
        beat()
        clock.sleep_until_ns(clock.now_ns() + PAUSE_NS)
