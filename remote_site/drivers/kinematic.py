"""The driver of a robot that follows perfectly: for tests, and for a loop without a cell."""

from common.clock import NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from remote_site.drivers.driver import DriverSetup, JointCommand, RobotReading
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.guard import JointGuard, Refused
from remote_site.safety.status import Code, reason
from remote_site.safety.stopping import stopping


class KinematicDriver:
    """A `Driver` whose joints are where they were last commanded, and which keeps the last limits itself.

    A command that breaks a limit is replaced by the stop from the one before it. After `stop`, or when commands cease
    for the time-out, the jerk-limited stop runs in the clock's time, and the arm must be activated anew, at rest.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._setup: DriverSetup | None = None
        self._sent: JointCommand | None = None
        self._since_ns = 0
        self._obeyed: int | None = None
        self._stop_ns: int | None = None
        self._fault = "not activated yet"

    def configure(self, setup: DriverSetup) -> None:
        """Take the limits and the time-out."""
        self._setup = setup
        self._guard = JointGuard(setup.limits, setup.dt)

    def activate(self, q0: Array) -> None:
        """Stand at `q0` and take commands from there."""
        if self._setup is None:
            raise DriverError("configure the kinematic driver before it is activated")
        motion = JointMotion.at_rest(q0)
        if len(q0) != len(self._setup.joint_names) or not motion.finite:
            raise DriverError(f"a posture has {len(self._setup.joint_names)} finite positions, not {q0}")
        if self._sent is not None and not self._motion(self._sent).resting:
            raise DriverError("the arm still moves; activate it when it rests")
        seq, gripper_open = (self._sent.seq, self._sent.gripper_open) if self._sent is not None else (0, False)
        self._sent = JointCommand(seq, self._clock.now_ns(), motion.q, motion.dq, motion.ddq, gripper_open)
        self._since_ns = self._clock.now_ns()
        self._stop_ns, self._fault, self._obeyed = None, "", None

    def read(self) -> RobotReading:
        """Where the joints are; there is no gripper to measure."""
        sent = self._activated()
        self._watch()
        motion = self._motion(sent)
        return RobotReading(
            t_ns=self._clock.now_ns(),
            q=motion.q,
            dq=motion.dq,
            gripper=None,
            ready=not self._fault,
            fault=self._fault,
            obeyed_seq=self._obeyed,
        )

    def write(self, command: JointCommand) -> JointCommand:
        """Obey a command, or the stop in its place; DriverError while stopped."""
        sent = self._activated()
        self._watch()
        if self._fault:
            raise DriverError(self._fault)
        motion = command.motion
        if isinstance(self._guard.check(motion, sent.motion), Refused):
            motion = self._guard.stop(sent.motion)
        self._sent = JointCommand(command.seq, command.t_ns, motion.q, motion.dq, motion.ddq, command.gripper_open)
        self._since_ns, self._obeyed = self._clock.now_ns(), command.seq
        return self._sent

    def stop(self) -> None:
        """Stop within the limits, and hold."""
        self._halt(self._clock.now_ns(), "stopped; activate anew")

    def deactivate(self) -> None:
        """Stop, and take no more commands."""
        self.stop()

    def _activated(self) -> JointCommand:
        if self._sent is None:
            raise DriverError("activate the kinematic driver before it is read or commanded")
        return self._sent

    def _watch(self) -> None:
        """Begin the stop when commands have ceased."""
        if self._setup is None:
            return
        silent_ns = self._clock.now_ns() - self._since_ns
        limit_ns = self._setup.command_timeout_ns
        if silent_ns > limit_ns and self._obeyed is not None:
            late = reason(Code.COMMAND_TIMEOUT, age_ms=silent_ns / 1e6, limit_ms=limit_ns / 1e6)
            self._halt(self._since_ns + limit_ns, f"{late.sentence}; activate anew")

    def _halt(self, at_ns: int, why: str) -> None:
        if self._stop_ns is None:
            self._stop_ns, self._fault = at_ns, why

    def _motion(self, sent: JointCommand) -> JointMotion:
        if self._stop_ns is None or self._setup is None:
            return sent.motion
        return stopping(sent.motion, self._setup.limits, (self._clock.now_ns() - self._stop_ns) / NS_PER_S)
