"""The C500C driver and the emulated controller of an A465 on one clock."""

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from common.clock import NS_PER_MS, FakeClock
from common.errors import DriverError
from common.messages.robot import GripperCommand
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.driver import C500cDriver
from remote_site.drivers.c500c.emulation import EmulatedPort, Emulation
from remote_site.drivers.c500c.emulator import Emulated, EmulatedController
from remote_site.drivers.driver import DriverSetup, JointCommand, RobotReading
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.limits import load_arm

ROBOT = RobotConfig()
MODEL, LIMITS = load_arm(ROBOT)
SETUP = DriverSetup(MODEL.joint_names, LIMITS, 0.004, 50 * NS_PER_MS)


class EmulatedA465:
    """The driver and the emulated controller on one clock; `longest` is the longest queue of setpoints so far."""

    def __init__(self, *, loss: float = 0.0, emulated: Emulated | None = None, **options: Any) -> None:
        self.clock = FakeClock(1000 * NS_PER_MS)
        self.controller = EmulatedController(ROBOT.start, emulated or Emulated())
        self.emulation = Emulation(self.controller, self.clock.now_ns(), loss=loss)
        self.driver = C500cDriver(C500cConfig(**options), EmulatedPort(self.emulation, self.clock), self.clock)
        self.seq, self.longest = 0, 0

    def run(self, ms: float) -> RobotReading:
        """Read every 2 ms for this time; the last reading."""
        for _ in range(round(ms / 2)):
            self.clock.advance_ms(2)
            try:
                reading = self.driver.read()
            except DriverError:
                continue
            self.longest = max(self.longest, len(self.controller.player.queue))
        return reading

    def ready(self) -> Self:
        """Configured and activated."""
        self.driver.configure(SETUP)
        self.run(100)
        self.driver.activate(ROBOT.start)
        assert self.run(60).fault is None
        return self

    def send(self, q: ArrayLike, periods: int = 1, gripper: GripperCommand = GripperCommand.OPEN) -> RobotReading:
        """Command rest at `q` (6,) rad for some periods of the controller; the last reading."""
        for _ in range(periods):
            self.seq += 1
            zero = np.zeros(6)
            self.driver.write(JointCommand(self.seq, self.clock.now_ns(), np.array(q), zero, zero, gripper))
            reading = self.run(67)
        return reading
