"""The driver of an FR3: setpoints to the process that feeds its motion each millisecond, its readings, its faults."""

from typing import Protocol

import numpy as np

from common.clock import NS_PER_MS, Clock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import (
    RESTING_RAD_S,
    Capabilities,
    DriverSetup,
    GripperReading,
    JointCommand,
    RobotReading,
)
from remote_site.drivers.faults import NOT_ACTIVATED, STILL_MOVING, STOPPED, FaultCode, RobotFault
from remote_site.drivers.franka.arm_memory import ArmMemory, ArmStatus, GripperMemory
from remote_site.drivers.franka.config import FrankaConfig
from remote_site.drivers.franka.connecting import SILENT
from remote_site.drivers.franka.played_motion import WATCHDOG_MS
from remote_site.drivers.franka.robot_limits import JOINTS, check_fr3
from remote_site.drivers.gripper_orders import GripperOrders
from remote_site.drivers.supervisor.orders import DriverOrder

RATE_HZ = 1000.0
CONNECT_NS = 4000 * NS_PER_MS
POLL_NS = 5 * NS_PER_MS
STALE_NS = 50 * NS_PER_MS


class RobotSide(Protocol):
    """The part that talks to the robot, and the memory it shares with the driver; `gripper` is None without a gripper.

    `failure` is why it has ended by itself, "" while it has not.
    """

    arm: ArmMemory
    gripper: GripperMemory | None

    def start(self, setup: DriverSetup) -> None: ...

    def failure(self) -> str: ...

    def end(self) -> None: ...


class FrankaDriver:
    """A `Driver` whose calls only read and write memory; the robot's errors are acknowledged by `activate` alone."""

    def __init__(self, config: FrankaConfig, side: RobotSide, clock: Clock) -> None:
        self._config, self._side, self._clock = config, side, clock
        self._setup: DriverSetup | None = None
        self._activation = 0
        self._running = False
        self._q0: Array = np.zeros(JOINTS)
        self._gripper = GripperOrders()

    @property
    def capabilities(self) -> Capabilities:
        """Seven joints that follow after a lag of their own; a gripper whose force is not measured."""
        config = self._config
        return Capabilities(
            rate_hz=RATE_HZ,
            joints=JOINTS,
            gripper=config.gripper,
            force=False,
            watchdog_ms=WATCHDOG_MS,
            lag_ms=config.follow_ms,
        )

    def configure(self, setup: DriverSetup) -> None:
        """Connect to the robot, and wait for its first state; DriverError where it does not answer."""
        check_fr3(setup)
        self._setup = setup
        self._side.start(setup)
        try:
            self._wait_for_state()
        except BaseException:
            self._side.end()  # a process that still waits for the robot would keep this one from ending
            raise

    def activate(self, q0: Array) -> None:
        """Have the robot acknowledge its errors, and begin a motion at rest at `q0`."""
        status = self._measured()
        if np.abs(status.dq).max() > RESTING_RAD_S or not np.isfinite(q0).all():
            raise DriverError(STILL_MOVING.sentence)
        self._activation += 1
        self._running, self._q0 = True, np.array(q0, dtype=float)
        self._withdraw_grip()
        self._order(self._at_rest(), run=True)

    def read(self) -> RobotReading:
        """The newest state of the robot; DriverError before the first."""
        status = self._measured()
        opening_m = self._side.gripper.opening_m if self._side.gripper is not None else None
        grip = GripperReading(opening_m, None) if opening_m is not None else None
        return RobotReading(status.t_ns, status.q, status.dq, grip, self._fault(status), self._obeyed(status))

    def write(self, command: JointCommand) -> JointCommand:
        """Hand a setpoint on; DriverError before activation, after a stop and after a fault."""
        if not self._running:
            raise DriverError(STOPPED.sentence if self._activation else NOT_ACTIVATED.sentence)
        self._order(command, run=True)
        self._grip(command)
        return command

    def stop(self) -> None:
        """Have the arm brake within its limits, and end its motion: the robot then holds it.

        Fingers that have begun to move come to their end: the maker's client waits for them, and cannot be interrupted.
        """
        self._withdraw_grip()
        if self._running:
            self._order(self._at_rest(), run=False)
        self._running = False

    def deactivate(self) -> None:
        """Stop, and end the connection."""
        self.stop()
        self._side.end()

    def _order(self, command: JointCommand, *, run: bool) -> None:
        self._side.arm.orders.write(DriverOrder(self._activation, run, 0, command))

    def _grip(self, command: JointCommand) -> None:
        if command.gripper is GripperCommand.KEEP:
            self._withdraw_grip()
        order = self._gripper.note(command.gripper, command.t_ns)
        if order is not None and self._side.gripper is not None:
            self._side.gripper.order(order)

    def _withdraw_grip(self) -> None:
        if self._gripper.withdraw() and self._side.gripper is not None:
            self._side.gripper.withdraw()

    def _at_rest(self) -> JointCommand:
        zero = np.zeros(JOINTS)
        return JointCommand(0, self._clock.now_ns(), self._q0, zero, zero, GripperCommand.KEEP)

    def _wait_for_state(self) -> None:
        end_ns = self._clock.now_ns() + CONNECT_NS
        while not self._side.arm.status.t_ns:
            if failure := self._side.failure():
                raise DriverError(failure)
            if self._clock.now_ns() > end_ns:
                raise DriverError(SILENT.format(host=self._config.host))
            self._clock.sleep_until_ns(self._clock.now_ns() + POLL_NS)

    def _measured(self) -> ArmStatus:
        if self._setup is None:
            raise DriverError("configure the franka driver first")
        status = self._side.arm.status
        if not status.t_ns:
            raise DriverError("the robot has not been measured yet")
        return status

    def _obeyed(self, status: ArmStatus) -> int | None:
        return status.obeyed_seq if status.activation == self._activation else None

    def _fault(self, status: ArmStatus) -> RobotFault | None:
        stale = self._clock.now_ns() - status.t_ns > STALE_NS
        if stale and (failure := self._side.failure()):
            return RobotFault(FaultCode.PROCESS, failure)
        if status.activation != self._activation:
            return NOT_ACTIVATED
        if status.fault is not None:
            return status.fault
        if not self._running:
            return STOPPED if self._activation else NOT_ACTIVATED
        return None if status.active else NOT_ACTIVATED
