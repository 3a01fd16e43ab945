"""What a robot driver is: configure, activate, (read, write)*, stop, deactivate."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from common.errors import DriverError
from common.geometry import Array
from remote_site.drivers.faults import RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits

RESTING_RAD_S = 0.02  # measured speed of a joint at rest, at most


@dataclass(frozen=True, slots=True)
class JointCommand:
    """The commanded motion at the next tick: joints in rad, rad/s, rad/s² in the model's order, and the gripper.

    `seq` rises by one each command, `t_ns` is the sender's monotonic time.
    """

    seq: int
    t_ns: int
    q: Array
    dq: Array
    ddq: Array
    gripper_open: bool

    @property
    def motion(self) -> JointMotion:
        """The joints' part of the command."""
        return JointMotion(self.q, self.dq, self.ddq)


@dataclass(frozen=True, slots=True)
class GripperReading:
    """The gripper as measured: opening between the fingers in m, grip force in N or None where none is measured."""

    opening_m: float
    force_n: float | None


@dataclass(frozen=True, slots=True)
class RobotReading:
    """The robot as measured at `t_ns`: joints in rad and rad/s, the gripper if there is one.

    `fault` is why the robot cannot take commands, None while it can. `obeyed_seq` is the newest command that has
    reached the robot's motion, None before the first.
    """

    t_ns: int
    q: Array
    dq: Array
    gripper: GripperReading | None
    fault: RobotFault | None
    obeyed_seq: int | None

    @property
    def moving(self) -> bool:
        """Any joint moves."""
        return float(np.abs(self.dq).max()) > RESTING_RAD_S


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What a robot can do: commands per second it takes, and joints, None for any number.

    `gripper` and `force`: it has one, and measures its force. `watchdog_ms`: without a call for this long the robot
    stops by itself, None when it does not. `queued_periods`: how many periods its motion lags behind commands.
    """

    rate_hz: float
    joints: int | None
    gripper: bool
    force: bool
    watchdog_ms: float | None
    queued_periods: int = 0

    def __post_init__(self) -> None:
        """Raise DriverError for values that no robot has."""
        if not (math.isfinite(self.rate_hz) and self.rate_hz > 0):
            raise DriverError(f"rate_hz is {self.rate_hz}; give the commands a second that the robot takes, above 0")


@dataclass(frozen=True, slots=True)
class DriverSetup:
    """What every driver is configured with: joints by name, limits, tick in s, command time-out in ns.

    The gripper closes with at most `grip_force_n`.
    """

    joint_names: tuple[str, ...]
    limits: JointLimits
    dt: float
    command_timeout_ns: int
    grip_force_n: float = 25.0


class Driver(Protocol):
    """A robot, real or simulated; DriverError states why a call is refused, and no call takes longer than 50 ms.

    `configure` comes once. `activate` makes the robot take commands from rest at `q0`; the `fault` of `read` shows when
    it does. `read` raises while nothing has been measured. `write` sends a motion that the driver's process has
    checked, and returns what was really sent. `stop` brings the robot to rest immediately and may be repeated; then
    only a new activation moves it. A fault that one reading shows is kept by the driver's process until the next
    activation. `deactivate` ends it all.
    """

    @property
    def capabilities(self) -> Capabilities: ...

    def configure(self, setup: DriverSetup) -> None: ...

    def activate(self, q0: Array) -> None: ...

    def read(self) -> RobotReading: ...

    def write(self, command: JointCommand) -> JointCommand: ...

    def stop(self) -> None: ...

    def deactivate(self) -> None: ...
