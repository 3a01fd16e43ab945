"""The gripper's process: opens and closes as the driver orders, and measures in between."""

import math
from collections.abc import Callable
from typing import NoReturn

import structlog

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.messages.robot import GripperCommand
from remote_site.drivers.franka.arm_memory import HandMemory
from remote_site.drivers.franka.robot_port import HandPort, LinkLostError, RobotRefusedError

PAUSE_NS = 10 * NS_PER_MS
AGAIN_NS = NS_PER_S
HOMED_M = 0.01  # a hand that was not homed since its start reports a width of 0


class HandLoop:
    """Connects and measures; each turn does the newest order, if there is one, and measures again.

    The maker's client waits while the fingers move, so nothing is measured meanwhile. A gripper that fails stops no
    arm: what it fails at is logged, and its opening shows the rest.
    """

    def __init__(
        self, connect: Callable[[], HandPort], memory: HandMemory, clock: Clock, speed_m_s: float, force_n: float
    ) -> None:
        self._connect, self._memory, self._clock = connect, memory, clock
        self._speed_m_s, self._force_n = speed_m_s, force_n
        self._hand: HandPort | None = None
        self._told = False  # that there is no link
        self._done = 0
        self._widest_m = 0.0
        self._log = structlog.get_logger()

    def turn(self) -> None:
        """Do what is ordered, then measure."""
        count, gripper = self._memory.ordered()
        try:
            if self._hand is None:
                hand = self._connect()
                self._widest_m, self._hand = hand.read().widest_m, hand
            if count != self._done:
                self._obey(self._hand, count, gripper)
            state = self._hand.read()
            self._widest_m = state.widest_m
            self._memory.report(self._done, state.opening_m)
        except LinkLostError as error:
            if self._hand is not None or not self._told:
                cure = "without a Franka Hand set driver.options.gripper = false"
                self._log.warning("no link to the gripper", reason=str(error), cure=cure)
            self._hand, self._told = None, True
            self._memory.report(self._done, math.nan)
            self._clock.sleep_until_ns(self._clock.now_ns() + AGAIN_NS)

    def _obey(self, hand: HandPort, count: int, gripper: GripperCommand) -> None:
        try:
            if gripper is GripperCommand.OPEN and self._widest_m < HOMED_M:
                raise RobotRefusedError("it has not been homed, and does not know how wide it opens")
            if gripper is GripperCommand.OPEN:
                done = hand.open(self._widest_m, self._speed_m_s)
            else:
                done = hand.close(self._speed_m_s, self._force_n)
        except LinkLostError:
            raise
        except DriverError as error:
            self._log.warning("the gripper refuses", said=str(error), cure="home it in Desk")
        else:
            if not done:
                self._log.warning("the gripper did not end where it was sent", ordered=gripper.value)
        finally:
            self._done = count


def run_hand_loop(loop: HandLoop, clock: Clock, beat: Callable[[], None]) -> NoReturn:
    """Turn until this process is ended; what the gripper holds stays held."""
    while True:
        loop.turn()
        beat()
        clock.sleep_until_ns(clock.now_ns() + PAUSE_NS)
