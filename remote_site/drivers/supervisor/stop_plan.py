"""The verified stop under way: its onset, where it is at a time, and which command may take over from it; pure."""

from dataclasses import dataclass

from common.clock import NS_PER_S
from remote_site.drivers.driver import JointCommand
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.guard import JointGuard
from remote_site.safety.stopping import stopping

MAX_LEAD_TICKS = 0.25  # maximum lead of the written stop over the command that takes over from it


@dataclass(frozen=True, slots=True)
class StopPlan:
    """The jerk-limited stop from `motion` as of `onset_ns`, monotonic time, which is `plan_ns` in the writer's plan."""

    onset_ns: int
    plan_ns: int
    motion: JointMotion
    limits: JointLimits

    def at(self, t_ns: int) -> JointMotion:
        """The motion at a time; before the onset, the motion there."""
        return stopping(self.motion, self.limits, max(t_ns - self.onset_ns, 0) / NS_PER_S)

    def at_plan(self, plan_ns: int) -> JointMotion:
        """The motion at a plan time."""
        return self.at(self.onset_ns + plan_ns - self.plan_ns)

    def plan_ns_at(self, t_ns: int) -> int:
        """The plan time of a time: during a stop, the plan advances with the clock."""
        return self.plan_ns + t_ns - self.onset_ns

    def hands_over_to(self, command: JointCommand, written_ns: int, guard: JointGuard) -> bool:
        """Return whether control may continue with a command when the stop was written to the plan time `written_ns`.

        The command has to be where the stop is at the command's own time, and what was written hardly beyond it.
        """
        lead_ns = written_ns - self.plan_ns_at(command.t_ns)
        in_time = lead_ns <= MAX_LEAD_TICKS * round(guard.dt * NS_PER_S)
        return guard.same(command.motion, self.at(command.t_ns)) and in_time
