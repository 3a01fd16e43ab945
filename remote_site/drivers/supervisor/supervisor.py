"""Between commands and driver: checks every command once more, and stops the robot when they cease or break a limit."""

from collections.abc import Sequence

import numpy as np

from common.clock import Clock
from common.geometry import Array
from remote_site.drivers.driver import Driver, DriverSetup, JointCommand, RobotReading
from remote_site.drivers.faults import NOT_ACTIVATED, STILL_MOVING, STOPPED, FaultCode, RobotFault, apart
from remote_site.drivers.supervisor.commanded_motion import CommandedMotion
from remote_site.drivers.supervisor.following_check import FollowingCheck
from remote_site.drivers.supervisor.grip import GripWatch
from remote_site.drivers.supervisor.orders import CommandWatchdog, DriverOrder, command_timeout
from remote_site.drivers.supervisor.reading_check import ReadingCheck
from remote_site.drivers.supervisor.state import ACTIVE, DRIVEN, INACTIVE, SupervisorState
from remote_site.drivers.supervisor.watched_driver import CallMark, WatchedDriver
from remote_site.drivers.supervisor.writer import ObeyedCommands, PacedWriter
from remote_site.kinematics.joints import JointMotion

APART_RAD = 0.05


class DriverSupervisor:
    """The state machine that enforces the last limits and the command time-out of any driver, in its clock's time.

    `SupervisorState` has the transition table. To be read: `state`, `fault` (None while the robot takes commands),
    `activation` (the last one handled), `reading` (the last good one) and `oldest_ns` (how old it may become),
    `commanded`, `obeyed`, `grip`.
    """

    def __init__(self, driver: Driver, setup: DriverSetup, clock: Clock, mark: CallMark, grip: GripWatch) -> None:
        capabilities = driver.capabilities
        readings = ReadingCheck(capabilities, setup)
        self.oldest_ns = readings.oldest_ns
        self._names = setup.joint_names
        self._driver = WatchedDriver(driver, clock, mark, readings)
        self._watchdog, self._following = CommandWatchdog(setup), FollowingCheck(capabilities, setup.joint_names)
        self._writer = PacedWriter(self._driver, capabilities, setup)
        self.commanded = CommandedMotion(self._writer, setup)
        self.grip = grip
        self.state = SupervisorState.IDLE
        self.fault: RobotFault | None = NOT_ACTIVATED
        self.activation = 0
        self.reading: RobotReading | None = None

    def take(self, orders: Sequence[DriverOrder], now_ns: int) -> None:
        """Obey what control has ordered since the last call, oldest first, and stop when it was silent for too long."""
        self._watch(now_ns)
        for order in orders:
            if order.activation != self.activation:
                self._activate(order, now_ns)
            elif self.state in ACTIVE and not order.run:
                self.stop(STOPPED, now_ns)
            elif self.state in ACTIVE:
                self._watchdog.note_order(now_ns)
                if order.stop_count == self.commanded.stop_count:
                    self._obey(order.command, now_ns)

    def step(self, now_ns: int) -> None:
        """Write what is due, and read the robot."""
        self.commanded.advance(now_ns)
        failed = self._writer.step(self.commanded.stop, now_ns) if self.state in DRIVEN else None
        if self.state in DRIVEN:
            self._following.note(self._writer.written.q, now_ns)
        self._read(now_ns)
        if failed is not None:
            self._fail(failed)  # unless the reading has just given the robot's own reason
        stopped = self.state is SupervisorState.STOPPING and self.commanded.motion.resting
        if stopped and self._writer.settled(now_ns):
            self.state, self.commanded.stop = SupervisorState.HELD, None
            self.fault = self._driver.stop() or self.fault

    def stop(self, why: RobotFault, now_ns: int) -> None:
        """Begin the stop as of the last command, and take no more until activated."""
        if self.state in ACTIVE:
            self.commanded.begin_stop(now_ns)
            self._writer.withdraw_grip()
            self.state, self.fault = SupervisorState.STOPPING, why

    @property
    def due_ns(self) -> int | None:
        """The time at which a motion that waits may be written, ns; None if none waits."""
        return self._writer.due_ns if self.state in DRIVEN else None

    @property
    def written(self) -> JointCommand:
        """The motion that the robot was given last, the number of control's command it comes from, and when; 0 before.

        A stop comes from the command that it began with.
        """
        return self._writer.written

    @property
    def obeyed(self) -> ObeyedCommands:
        """The commands that the robot has said to obey."""
        return self._writer.obeyed

    @property
    def settled(self) -> bool:
        """Nothing moves, and nothing will without an activation."""
        return self.state in INACTIVE and not (self.reading is not None and self.reading.moving)

    def _watch(self, now_ns: int) -> None:
        command_ns, limit_ns = self.commanded.command_ns, self._watchdog.timeout_ns
        silent_ns, late = self._watchdog.silent_ns(command_ns, now_ns), self._watchdog.late(command_ns, now_ns)
        slow = self._watchdog.slow(now_ns)
        if slow is not None and self.state in {*ACTIVE, SupervisorState.ACTIVATING}:
            self._fail(slow)  # a process that is always late cannot lead the robot to rest either
        if self.state not in ACTIVE:
            return
        if silent_ns > limit_ns:
            self.stop(command_timeout(silent_ns, limit_ns), now_ns)
        elif late and self.commanded.motion.resting:
            self._writer.repeat()  # the robot's own watchdog is for the end of this process, not for silence of control
        elif late and self.state is SupervisorState.FOLLOWING:
            self.commanded.begin_stop(now_ns)
            self.commanded.stop_count += 1
            self.state = SupervisorState.BRAKING

    def _obey(self, command: JointCommand, now_ns: int) -> None:
        refused = self.commanded.obey(command, now_ns)
        if refused is not None:
            self.stop(refused, now_ns)
        elif self.commanded.stop is None:
            self.state = SupervisorState.FOLLOWING

    def _activate(self, order: DriverOrder, now_ns: int) -> None:
        self.activation, q0 = order.activation, order.command.q
        refused = STILL_MOVING if self.state in DRIVEN else self._unfit(q0)
        if refused is STILL_MOVING:
            self.stop(STILL_MOVING, now_ns)
            self.fault = STILL_MOVING
            return
        if refused is None:
            self.state, self.fault = SupervisorState.ACTIVATING, NOT_ACTIVATED
            self.commanded.restart(order.command, now_ns)
            self._following.restart(q0, now_ns)
            refused = self._driver.activate(q0)
        if refused is not None and self.state is SupervisorState.ACTIVATING:
            self._driver.stop()  # it may be half activated: the robot must not wait for commands that will not come
            self.state = SupervisorState.IDLE
        self.fault = refused or self.fault

    def _unfit(self, q0: Array) -> RobotFault | None:
        """Say why the robot must not be activated at `q0`: it cannot be read now, moves, or is elsewhere."""
        reading = self._driver.read()
        if isinstance(reading, RobotFault):
            return reading
        self.reading = reading
        if reading.moving:
            return STILL_MOVING
        return self._apart(q0, reading.q)

    def _read(self, now_ns: int) -> None:
        reading = self._driver.read()
        if isinstance(reading, RobotFault):
            if self.reading is not None or self.state not in INACTIVE or reading.code is not FaultCode.REFUSED:
                self._fail(reading)  # otherwise nothing has been measured yet
            return
        self.reading = reading
        if self.state is SupervisorState.ACTIVATING:
            self._answer(reading)
        elif self.state in DRIVEN:
            fault = reading.fault or self._following.judge(reading.q, now_ns)
            if fault is not None:
                self._fail(fault)
        if self.state is SupervisorState.IDLE:
            self.commanded.motion = JointMotion.at_rest(reading.q)
        self.obeyed.confirm(reading.obeyed_seq)
        self.grip.observe(reading.gripper, now_ns, self._writer.command.gripper)

    def _answer(self, reading: RobotReading) -> None:
        """End the activation when the robot has answered it."""
        elsewhere = self._apart(self.commanded.motion.q, reading.q)
        if reading.fault is None and elsewhere is not None:
            self._fail(elsewhere)
        elif reading.fault is None:
            self.state, self.fault = SupervisorState.FOLLOWING, None
        elif not reading.fault.calm:
            self.state, self.fault = SupervisorState.HELD, reading.fault

    def _apart(self, given: Array, read: Array) -> RobotFault | None:
        near = np.abs(read - given).max() <= APART_RAD  # false where a position is not a number
        return None if near else apart(self._names, given.tolist(), read.tolist())

    def _fail(self, fault: RobotFault) -> None:
        """Latch a fault; a driven robot can no longer be led to rest and has to stop by itself."""
        if fault.code is FaultCode.REFUSED:
            fault = RobotFault(FaultCode.DRIVER, fault.sentence)
        if self.fault is None or self.fault.calm:
            self.fault = fault
        if self.state in INACTIVE:
            return
        self.state, self.commanded.stop = SupervisorState.IDLE, None
        self.fault = self._driver.stop_after(self.fault)
