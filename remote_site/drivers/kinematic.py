"""The driver of a robot that follows perfectly: for tests, and for a loop without a cell."""

import numpy as np

from common.clock import NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import Capabilities, DriverSetup, JointCommand, RobotReading
from remote_site.drivers.faults import NOT_ACTIVATED, STILL_MOVING, STOPPED, RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stopping

CAPABILITIES = Capabilities(rate_hz=1000.0, joints=None, gripper=False, force=False, watchdog_ms=None)


class KinematicDriver:
    """A `Driver` whose joints are where they were last commanded, and before that at `DriverSetup.start`.

    After `stop` the jerk-limited stop runs in the clock's time, and only an activation at rest moves the arm again. It
    has no watchdog: without its process there is no arm.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._setup: DriverSetup | None = None
        self._sent: JointCommand | None = None
        self._obeyed: int | None = None
        self._stop_ns: int | None = None

    @property
    def capabilities(self) -> Capabilities:
        """Any arm, without a gripper."""
        return CAPABILITIES

    def configure(self, setup: DriverSetup) -> None:
        """Take the limits of the stop."""
        self._setup = setup

    def activate(self, q0: Array) -> None:
        """Rest at `q0` and take commands from there."""
        if self._setup is None:
            raise DriverError("configure the kinematic driver before it is activated")
        motion = JointMotion.at_rest(q0)
        if len(q0) != len(self._setup.joint_names) or not motion.finite:
            raise DriverError(f"a posture has {len(self._setup.joint_names)} finite positions, not {q0}")
        if self._sent is not None and not self._motion(self._sent).resting:
            raise DriverError(STILL_MOVING.sentence)
        self._sent = JointCommand(0, self._clock.now_ns(), motion.q, motion.dq, motion.ddq, GripperCommand.KEEP)
        self._stop_ns, self._obeyed = None, None

    def read(self) -> RobotReading:
        """Read where the joints are; there is no gripper to measure."""
        if self._sent is None:
            return self._at_start()
        motion = self._motion(self._sent)
        fault: RobotFault | None = STOPPED if self._stop_ns is not None else None
        return RobotReading(self._clock.now_ns(), motion.q, motion.dq, None, fault, self._obeyed)

    def write(self, command: JointCommand) -> JointCommand:
        """Obey a command; DriverError while stopped."""
        self._activated()
        if self._stop_ns is not None:
            raise DriverError(STOPPED.sentence)
        self._sent, self._obeyed = command, command.seq
        return command

    def stop(self) -> None:
        """Stop within the limits, and hold."""
        if self._stop_ns is None:
            self._stop_ns = self._clock.now_ns()

    def deactivate(self) -> None:
        """Stop, and take no more commands."""
        self.stop()

    def _activated(self) -> JointCommand:
        if self._sent is None:
            raise DriverError("activate the kinematic driver before it is commanded")
        return self._sent

    def _at_start(self) -> RobotReading:
        if self._setup is None:
            raise DriverError("configure the kinematic driver before it is read")
        zero = np.zeros(len(self._setup.joint_names))
        start = zero if self._setup.start is None else self._setup.start
        return RobotReading(self._clock.now_ns(), start, zero, None, NOT_ACTIVATED, None)

    def _motion(self, sent: JointCommand) -> JointMotion:
        if self._stop_ns is None or self._setup is None:
            return sent.motion
        return stopping(sent.motion, self._setup.limits, (self._clock.now_ns() - self._stop_ns) / NS_PER_S)
