"""One motion of the arm, from where the robot holds its joints until it rests again, millisecond by millisecond; pure."""

import numpy as np

from common.geometry import Array
from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.franka.robot_limits import FR3, TICK_S, StepCheck
from remote_site.drivers.franka.setpoint_path import SetpointPath
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import JointStop, stops

HOLD_S = 0.02  # at rest, before the motion is ended
MOST_LATE_S = 0.2
STARVED = RobotFault(FaultCode.LINK, "the next setpoint came too late, the arm has braked", "starved")
SLOW_CLOCK = RobotFault(
    FaultCode.LINK,
    "the robot's clock runs slower than this machine's, the arm has braked; a simulator needs a less busy machine",
    "slow clock",
)


class ArmMotion:
    """Begins at rest at `held` (7,) rad, where the robot wants its joints; they were measured at `q0`.

    A joint is sent as far from its setpoint as it was held from where it was measured: gravity pulls it as far away.
    `fault` is why it has braked by itself, None while it has not; `finished` with the last step.
    """

    def __init__(self, held: Array, q0: Array, setup: DriverSetup, buffer_s: float) -> None:
        self._limits = setup.limits
        self._offset = held - q0
        self._path = SetpointPath(q0, setup.dt, buffer_s)
        self._check = StepCheck(FR3, held)
        self._motion = JointMotion.at_rest(q0)
        self._stops: list[JointStop] | None = None
        self._braked_s = 0.0
        self.fault: RobotFault | None = None

    def add(self, command: JointCommand) -> None:
        """Take a setpoint, unless it brakes."""
        if self._stops is None:
            self._path.add(command.motion, command.seq, command.t_ns)

    def brake(self, why: RobotFault | None = None) -> None:
        """Come to rest within the limits of the setup, and end."""
        if self._stops is None:
            self._stops, self.fault = stops(self._motion, self._limits), why

    @property
    def obeyed(self) -> int | None:
        """The number of the setpoint that is gone to, None before the first."""
        return self._path.seq

    @property
    def finished(self) -> bool:
        """The arm rests, and has been held there."""
        if self._stops is None:
            return False
        return self._braked_s >= max(stop.duration for stop in self._stops) + HOLD_S

    def step(self, ticks: int, now_ns: int) -> Array:
        """Where the joints are to be (7,) rad, `ticks` milliseconds after the last step."""
        if self._stops is None:
            self._follow(ticks, now_ns)
        if self._stops is not None:
            self._braked_s += ticks * TICK_S
            states = zip(*(stop.at(self._braked_s) for stop in self._stops), strict=True)
            self._motion = JointMotion(*(np.array(values) for values in states))
        q: Array = self._motion.q + self._offset
        self._check.take(q, ticks)
        return q

    def _follow(self, ticks: int, now_ns: int) -> None:
        """Go on along the path, or begin to brake where that is not possible."""
        motion = self._path.advance(ticks * TICK_S, now_ns)
        if self._path.starved:
            self.brake(STARVED)
        elif self._path.late_s(now_ns) > MOST_LATE_S:
            self.brake(SLOW_CLOCK)
        elif broken := self._check.broken(motion.q + self._offset, ticks):
            self.brake(RobotFault(FaultCode.LIMITS, f"{broken}; the arm has braked", "step"))
        else:
            self._motion = motion
