"""A stepped FR3 under its driver: activated, moved by setpoints of its first joint, and looked at."""

import numpy as np

from common.messages.robot import GripperCommand
from remote_site.drivers.driver import JointCommand, RobotReading
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from tests.remote_site.drivers.franka.fake_robot import SETUP, FakeGripper, FakeRobot, SteppedSide, stepped_driver

TICK_MS = 4


class DrivenArm:
    """The driver, configured; `robot` is the fake one."""

    def __init__(self, robot: FakeRobot | None = None, gripper: FakeGripper | None = None) -> None:
        self.robot, self.gripper = robot or FakeRobot(), gripper or FakeGripper()
        self.side = SteppedSide(self.robot, self.gripper)
        self.driver = stepped_driver(self.side)
        self.driver.configure(SETUP)
        self.seq = 0
        self._motion = JointMotion.at_rest(self.read().q)
        self._follower = JerkLimitedTracker(SETUP.limits, SETUP.dt)

    def read(self) -> RobotReading:
        return self.driver.read()

    def activate(self) -> "DrivenArm":
        self.side.pass_ms(20)
        q0 = self.read().q
        self._motion = JointMotion.at_rest(q0)
        self.driver.activate(q0)
        self.side.pass_ms(5)
        return self

    def write(self, motion: JointMotion, gripper: GripperCommand = GripperCommand.KEEP) -> None:
        self.seq += 1
        self._motion = motion
        at_ns = self.side.now_ns()
        self.driver.write(JointCommand(self.seq, at_ns, motion.q, motion.dq, motion.ddq, gripper))

    def move(self, ms: int, ahead_rad: float = 0.6) -> "DrivenArm":
        """Lead the first joint towards `ahead_rad` from where it is, a setpoint each tick."""
        target = self._motion.q + np.array([ahead_rad, *np.zeros(6)])
        for _ in range(ms // TICK_MS):
            self._follower.reset(self._motion)
            motion = self._follower.track(JointMotion.at_rest(target))
            assert isinstance(motion, JointMotion)
            self.write(motion)
            self.side.pass_ms(TICK_MS)
        return self

    def code(self) -> str:
        fault = self.read().fault
        return fault.code.value if fault is not None else ""
