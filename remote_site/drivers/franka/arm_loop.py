"""The arm's process: reads the robot each millisecond, and feeds its motion from the setpoints of the driver."""

from collections.abc import Callable

import numpy as np
import structlog

from common.clock import NS_PER_MS
from common.geometry import Array
from common.process.service import StopFlag
from remote_site.drivers.driver import DriverSetup
from remote_site.drivers.faults import FaultCode, RobotFault, apart
from remote_site.drivers.franka.arm_memory import ArmMemory, ArmStatus
from remote_site.drivers.franka.played_motion import PlayedMotion
from remote_site.drivers.franka.robot_errors import fault_of, mode_fault
from remote_site.drivers.franka.robot_port import (
    ArmState,
    LinkLostError,
    MotionAbortedError,
    MotionPort,
    RobotPort,
    RobotRefusedError,
    UnreachableError,
)
from remote_site.drivers.franka.robot_watch import RobotWatch

HELD_APART_RAD = 0.05  # of a joint that the robot holds elsewhere than it is: it is being pushed


class ArmLoop:
    """Connects, reads, moves when it is activated; each turn takes the robot's next millisecond."""

    def __init__(self, watch: RobotWatch, memory: ArmMemory, setup: DriverSetup) -> None:
        self._watch, self._memory, self._setup = watch, memory, setup
        self._port: MotionPort | None = None
        self._motion: PlayedMotion | None = None
        self._activation = 0
        self._q0: Array | None = None  # where an activation waits for the robot to be idle
        self._brakes = False
        self._fault: RobotFault | None = None
        self._aborted = ""  # what libfranka says of a motion that the robot has broken off

    @property
    def moving(self) -> bool:
        """A motion is under way, at rest or not."""
        return self._port is not None

    def brake(self) -> None:
        """Bring a motion that is under way to its end."""
        self._brakes, self._q0 = True, None

    def turn(self) -> None:
        """Take the robot's next state, and answer it."""
        self._take_orders()
        try:
            robot = self._watch.connected()
            if self._port is None:
                self._idle(robot)
            else:
                self._drive(self._port)
        except LinkLostError as error:
            self._lose(error)
        except MotionAbortedError as error:
            self._aborted = str(error)  # the next state says why
            self._end_motion(RobotFault(FaultCode.ROBOT, f"the robot has broken off its motion: {error}", "aborted"))
        except RobotRefusedError as error:
            self._end_motion(RobotFault(FaultCode.REFUSED, f"the robot refuses: {error}"))
            self._report()

    def _take_orders(self) -> None:
        for order in self._memory.orders.take():
            if order.activation != self._activation:
                if self._motion is not None:
                    self._motion.brake()
                self._activation, self._q0, self._brakes = order.activation, order.command.q, False
                self._fault = None
            elif not order.run:
                self.brake()
            elif self._motion is not None and not self._brakes:
                self._motion.add(order.command)

    def _idle(self, robot: RobotPort) -> None:
        state = self._watch.read(robot)
        if self._aborted:
            why = fault_of(state.errors or state.motion_errors, self._aborted) or mode_fault(state.mode)
            self._fault, self._aborted = why or self._fault, ""
        if self._q0 is not None:
            self._begin(robot, state, self._q0)
        self._report()

    def _begin(self, robot: RobotPort, state: ArmState, q0: Array) -> None:
        """Recover from what the last motion ended with, and begin another; only an activation leads here."""
        self._q0 = None
        if state.errors or state.mode == "Reflex":
            robot.recover()
            state = self._watch.read(robot)
        refused = fault_of(state.errors) or mode_fault(state.mode)
        if refused is None and np.abs(state.held - q0).max() > HELD_APART_RAD:
            refused = apart(self._setup.joint_names, q0.tolist(), state.held.tolist())
        if refused is not None:
            self._fault = refused
            return
        self._port = robot.start()
        self._motion = PlayedMotion(state.held, q0, self._setup)

    def _drive(self, port: MotionPort) -> None:
        before, stamped_ns, state = self._watch.state, self._watch.stamp_ns, self._watch.read(port)
        motion = self._motion
        if motion is None:
            return
        if self._brakes:
            motion.brake()
        is_newer = self._watch.stamp_ns > stamped_ns  # a state whose time lies far ahead is not
        ticks = max(round((state.t_ns - before.t_ns) / NS_PER_MS), 1) if before is not None and is_newer else 1
        q = motion.step(ticks, self._watch.stamp_ns)
        if motion.fault is not None and self._fault is None and self._q0 is None:
            self._fault = motion.fault
        port.write(q, finished=motion.finished)
        if motion.finished:
            self._end_motion(self._fault)
        self._report()

    def _end_motion(self, fault: RobotFault | None) -> None:
        self._port, self._motion, self._fault = None, None, fault

    def _lose(self, error: LinkLostError) -> None:
        """Connect again, after a while; the stamps show since when nothing is measured."""
        said = str(error)
        if not isinstance(error, UnreachableError):
            said = f"the robot does not answer any more ({said.removeprefix('libfranka: ')}): check cable and power"
        structlog.get_logger().warning("no link to the robot", reason=said)
        self._end_motion(RobotFault(FaultCode.LINK, said))
        self._watch.forget()
        self._q0, self._aborted = None, ""
        self._report()
        self._watch.wait()

    def _report(self) -> None:
        state, motion = self._watch.state, self._motion
        if state is None:
            return
        fault = self._fault
        if fault is None and motion is None:
            fault = fault_of(state.errors) or mode_fault(state.mode)
        active = motion is not None and fault is None and not self._brakes and self._q0 is None
        obeyed = motion.obeyed if motion is not None else None
        status = ArmStatus(self._watch.stamp_ns, self._activation, active, obeyed, state.q, state.dq, fault)
        self._memory.report(status)


def run_arm_loop(loop: ArmLoop, should_stop: StopFlag, beat: Callable[[], None]) -> None:
    """Turn until asked to end, and then until the arm rests; a robot that cannot be reached at all ends it."""
    while not should_stop() or loop.moving:
        if should_stop():
            loop.brake()
        loop.turn()
        beat()
