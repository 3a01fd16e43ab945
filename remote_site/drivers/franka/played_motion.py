"""One motion of the arm, from where the robot holds its joints until it rests again; pure."""

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array
from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.franka.robot_limits import FR3, TICK_S, StepCheck
from remote_site.drivers.franka.setpoint_filter import SetpointFilter, braking_limits
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import JointStop, stops

HOLD_S = 0.02  # at rest, before the motion is ended
WATCHDOG_MS = 100.0
STARVED = RobotFault(FaultCode.WATCHDOG, "setpoints ceased in motion, the arm has come to rest", "starved")


class PlayedMotion:
    """Begins at rest at `held` (7,) rad, where the robot wants its joints; they were measured at `q0`.

    A joint is sent as far from its setpoint as it was held from where it was measured: gravity pulls it as far away.
    `fault` is why it brakes by itself, None while it does not.
    """

    def __init__(self, held: Array, q0: Array, setup: DriverSetup) -> None:
        self._limits = setup.limits
        self._offset = held - q0
        self._filter = SetpointFilter(q0, setup.limits, setup.dt)
        self._check = StepCheck(FR3, held)
        self._stops: list[JointStop] | None = None
        self._braked_s = 0.0
        self.fault: RobotFault | None = None

    def add(self, command: JointCommand) -> None:
        """Take a setpoint."""
        self._filter.add(command.motion, command.seq, command.t_ns)

    def brake(self, why: RobotFault | None = None) -> None:
        """Come to rest within the limits of the setup, and end; setpoints count no more."""
        if self._stops is None:
            motion = self._filter.motion
            self._stops, self.fault = stops(motion, braking_limits(self._limits, motion)), why

    @property
    def obeyed(self) -> int | None:
        """The number of the setpoint that it goes with, None before the first."""
        return self._filter.seq

    @property
    def finished(self) -> bool:
        """The arm rests, and has been held there."""
        if self._stops is None:
            return False
        return self._braked_s >= max(stop.duration for stop in self._stops) + HOLD_S

    def step(self, ticks: int, now_ns: int) -> Array:
        """Compute where the joints are to be (7,) rad at `now_ns`, `ticks` milliseconds after the last step."""
        if self._stops is None:
            self._follow(ticks, now_ns)
        if self._stops is not None:
            self._braked_s += ticks * TICK_S
            states = zip(*(stop.at(self._braked_s) for stop in self._stops), strict=True)
            self._filter.motion = JointMotion(*(np.array(values) for values in states))
        q: Array = self._filter.motion.q + self._offset
        self._check.note_sent(q, ticks)
        return q

    def _follow(self, ticks: int, now_ns: int) -> None:
        """Go on with the setpoints; brake from the last step where they cease, or the next one breaks a limit."""
        if self._filter.starved_ns(now_ns) > WATCHDOG_MS * NS_PER_MS:
            self.brake(STARVED)
            return
        before = self._filter.motion
        for earlier in reversed(range(ticks)):
            self._filter.step(now_ns - earlier * NS_PER_MS)
        if broken := self._check.broken(self._filter.motion.q + self._offset, ticks):
            self._filter.motion = before
            self.brake(RobotFault(FaultCode.LIMITS, f"{broken}; the arm has braked", "step"))
