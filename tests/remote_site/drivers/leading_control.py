"""Control without a pipeline: it leads an arm to a goal, order by order."""

from common.clock import Clock
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.link import DriverLink, RobotReport
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.motion.jerk_limited import JerkLimitedTracker

RATE_HZ = RemoteConfig().control.rate_hz


class LeadingControl:
    """Plans from what was sent last, `sent`, as control does; `seq` is the number of the newest order."""

    def __init__(self, link: DriverLink, limits: JointLimits, clock: Clock, start: Array) -> None:
        self.sent, self.seq = JointMotion.at_rest(start), 0
        self._link, self._clock = link, clock
        self._follower = JerkLimitedTracker(limits, 1.0 / RATE_HZ)

    def order(self, goal: Array) -> RobotReport:
        """Order the next motion towards a goal; the report that was read before."""
        report = self._link.read()
        self._follower.reset(self.sent)
        motion = self._follower.track(JointMotion.at_rest(goal))
        assert isinstance(motion, JointMotion)
        self.seq += 1
        command = JointCommand(self.seq, self._clock.now_ns(), motion.q, motion.dq, motion.ddq, GripperCommand.KEEP)
        self.sent = self._link.write(command).motion
        return report
