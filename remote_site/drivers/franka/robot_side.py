"""The processes that talk to the robot and its gripper: one each, since the maker's client keeps Python's lock."""

import gc
from functools import partial

from common.clock import Clock
from common.errors import ProcessError
from common.process.children import Children, Heartbeat, ends_at_once
from common.process.service import StopFlag, ask_for_real_time
from remote_site.drivers.driver import DriverSetup
from remote_site.drivers.franka.arm_loop import ArmLoop, run_arm_loop
from remote_site.drivers.franka.arm_memory import ArmMemory, GripperMemory
from remote_site.drivers.franka.client import FrankaGripper, FrankaRobot
from remote_site.drivers.franka.config import FrankaConfig
from remote_site.drivers.franka.gripper_loop import GripperLoop, run_gripper_loop
from remote_site.drivers.franka.robot_watch import RobotWatch, connected_once

FIFO_PRIORITY = 48  # below control, above the driver's process: each millisecond of the robot is answered in time


class RobotProcesses:
    """A `RobotSide` of two processes, or of one without a gripper."""

    def __init__(self, config: FrankaConfig, clock: Clock) -> None:
        self._config, self._clock = config, clock
        self._children = Children("franka")
        self._ended = False
        self.arm = ArmMemory()
        self.gripper = GripperMemory() if config.gripper else None

    def start(self, setup: DriverSetup) -> None:
        """Start them; they connect by themselves."""
        self._children.start("arm", partial(self._run_arm, setup))
        if self.gripper is not None:
            run = partial(self._run_gripper, self.gripper, setup)
            self._children.start("gripper", lambda _, heartbeat: run(heartbeat), vital=False)

    def failure(self) -> str:
        """Say why the arm's process has ended; "" while it runs."""
        try:
            if not self._ended:
                self._children.check_alive()
        except ProcessError as error:
            return str(error)
        return ""

    def end(self) -> None:
        """Have the arm come to rest, and end both."""
        self._ended = True
        self._children.end()

    def _connect(self) -> FrankaRobot:
        """Without a connection no arm has to be stopped, and a robot that is silent would be waited for a minute."""
        with ends_at_once():
            return FrankaRobot(self._config.host, realtime=self._config.realtime)

    def _run_arm(self, setup: DriverSetup, should_stop: StopFlag, heartbeat: Heartbeat) -> None:
        connect = connected_once(self._connect)
        loop = ArmLoop(RobotWatch(connect, self._clock), self.arm, setup)
        ask_for_real_time(FIFO_PRIORITY)
        gc.collect()
        gc.freeze()  # collecting all that was imported would take several of the robot's milliseconds
        run_arm_loop(loop, should_stop, heartbeat.beat)

    def _run_gripper(self, memory: GripperMemory, setup: DriverSetup, heartbeat: Heartbeat) -> None:
        config = self._config
        connect = partial(FrankaGripper, config.host)
        loop = GripperLoop(connect, memory, self._clock, config.gripper_speed_m_s, setup.grip_force_n)
        with ends_at_once():  # the client waits for the fingers; what they hold stays held
            run_gripper_loop(loop, self._clock, heartbeat.beat)
