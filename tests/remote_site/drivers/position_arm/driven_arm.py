"""An arm under its driver, on a clock that is moved by hand."""

from dataclasses import replace
from typing import Any

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import JointCommand, RobotReading
from remote_site.drivers.position_arm.driver import PositionArmDriver
from tests.contracts.driver_stands import CONFIG, SETUP
from tests.contracts.position_arms import ServoArm

START = np.array(CONFIG.robot.start)
TURN_MS = 2.0


class DrivenArm:
    """A driver that is called as often as its process does, without the supervisor's judgement."""

    def __init__(self, kind: type[ServoArm] = ServoArm, **attributes: object) -> None:
        self.clock = FakeClock(NS_PER_S)
        self.arm: Any = kind(self.clock)  # tests put calls of their own in the place of its own
        for name, value in attributes.items():
            setattr(self.arm, name, value)
        self.driver = PositionArmDriver(self.arm, self.clock)
        self.setup = replace(SETUP, command_timeout_ns=200 * NS_PER_MS)
        self.driver.configure(self.setup)
        self.seq = 0

    def turns(self, ms: float) -> RobotReading | None:
        """The last reading of this long, None before there is one."""
        reading = None
        for _ in range(round(ms / TURN_MS)):
            self.clock.advance_ms(TURN_MS)
            try:
                reading = self.driver.read()
            except Exception:
                reading = None
        return reading

    def reading(self) -> RobotReading:
        """The reading of one more turn."""
        self.clock.advance_ms(TURN_MS)
        return self.driver.read()

    def active(self) -> "DrivenArm":
        """The same, activated where it is read."""
        self.turns(200)
        self.driver.activate(self.reading().q)
        return self

    def activate_again(self, ms: float) -> None:
        """Activate the arm where it is read, and command it to stay there for so long."""
        q = self.reading().q
        self.driver.activate(q)
        self.command(0.0, at=q)
        self.turns(ms)

    def command(
        self,
        ahead_rad: float,
        speed: float = 0.0,
        gripper: GripperCommand = GripperCommand.KEEP,
        at: Array = START,
    ) -> None:
        """A command of the first joint, relative to the start, or to where it is `at` (n,) in rad."""
        self.seq += 1
        unit = np.eye(6)[0]
        q, dq = at + ahead_rad * unit, speed * unit
        self.driver.write(JointCommand(self.seq, self.clock.now_ns(), q, dq, np.zeros(6), gripper))

    def at_speed(self, speed: float = 0.8, ms: float = 300.0) -> "DrivenArm":
        """The same, its first joint led at a constant speed for this long."""
        for k in range(round(ms / 10)):
            self.command(speed * k / 100, speed)
            self.turns(10)
        return self
