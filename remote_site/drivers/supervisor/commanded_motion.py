"""Commanded motion of the robot: control's last command, or the stop from it, and how control continues from that."""

from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.supervisor.stop_plan import StopPlan
from remote_site.drivers.supervisor.writer import PacedWriter
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.guard import JointGuard, Refused


class CommandedMotion:
    """Checks each command against the motion before it, and replaces commands by a stop and the stop by commands.

    To be read: `motion` (the last command's, or where the stop is), `stop` (the one under way), `stop_count` (how many
    were begun by late commands, or continued past a command), `command_ns` (when the last command was taken).
    """

    def __init__(self, writer: PacedWriter, setup: DriverSetup) -> None:
        self._guard, self._writer = JointGuard(setup.limits, setup.dt), writer
        self.motion = JointMotion.at_rest(writer.command.q)
        self.stop: StopPlan | None = None
        self.stop_count = 0
        self.command_ns: int | None = None

    def restart(self, command: JointCommand, now_ns: int) -> None:
        """Begin at rest where the command is."""
        self.motion, self.command_ns = JointMotion.at_rest(command.q), None
        self._writer.restart(command, now_ns)

    def advance(self, now_ns: int) -> None:
        """Update the motion while a stop is under way."""
        if self.stop is not None:
            self.motion = self.stop.at(now_ns)

    def begin_stop(self, now_ns: int) -> None:
        """Begin the stop as of the last command, unless one is under way."""
        onset_ns = self.command_ns or now_ns
        self.stop = self.stop or StopPlan(onset_ns, self._writer.plan_ns, self.motion, self._guard.limits)

    def obey(self, command: JointCommand, now_ns: int) -> RobotFault | None:
        """Take a command that follows the last one, or that takes over from the stop; the fault LIMITS if refused.

        A command that does not meet the stop counts as one stop more: control has to plan again.
        """
        if self.stop is None:
            verdict = self._guard.check(command.motion, self.motion)
            if isinstance(verdict, Refused):
                return RobotFault(FaultCode.LIMITS, f"{verdict.reason.sentence}; the arm stops")
            self._writer.add(command)
        elif self.stop.hands_over_to(command, self._writer.written_ns, self._guard):
            self._writer.hand_over(self.stop, command)
        else:
            self.stop_count += 1
            return None
        self.motion, self.command_ns, self.stop = command.motion, now_ns, None
        return None
