"""The interface of a robot driver: configure, activate, (read, write)*, stop, deactivate."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.faults import RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits, JointRange

RESTING_RAD_S = 0.02  # measured speed of a joint at rest, at most
LONGEST_LAG_MS = 1000.0  # of an arm that a hand can lead


@dataclass(frozen=True, slots=True)
class JointCommand:
    """The commanded motion at the next tick: joints in rad, rad/s, rad/s² in the model's order, and the gripper.

    `seq` rises by one each command, `t_ns` is the sender's monotonic time. With KEEP nothing is done to the gripper.
    """

    seq: int
    t_ns: int
    q: Array
    dq: Array
    ddq: Array
    gripper: GripperCommand

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

    `t_ns` is when it was measured, by the driver's clock, and never when it was read: a reading with the stamp of the
    last one is no new reading.
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
    """The abilities of a robot: commands per second it takes, and joints, None for any number.

    `gripper` and `force`: it has one, and measures its force. `watchdog_ms`: without a call for this long the robot
    stops by itself, None when it does not. `queued_periods`: how many periods its motion lags behind commands;
    `lag_ms`: by how much more it may, at most, ms. `holds`: without a command it stays where the last one sent it,
    and is led on from there after a pause, in steps that are no longer than at full speed.
    """

    rate_hz: float
    joints: int | None
    gripper: bool
    force: bool
    watchdog_ms: float | None
    queued_periods: int = 0
    lag_ms: float = 0.0
    holds: bool = False

    def __post_init__(self) -> None:
        """Raise DriverError for values that no robot has."""
        if not (math.isfinite(self.rate_hz) and self.rate_hz > 0):
            raise DriverError(f"rate_hz is {self.rate_hz}; give the commands a second that the robot takes, above 0")
        if not (math.isfinite(self.lag_ms) and 0 <= self.lag_ms <= LONGEST_LAG_MS):
            raise DriverError(f"lag_ms is {self.lag_ms}; give 0 to {LONGEST_LAG_MS:g}")

    @property
    def longest_lag_s(self) -> float:
        """From a command to the motion that it causes, at most: it waits for its turn, and is gone to for a period."""
        return (self.queued_periods + 2) / self.rate_hz + self.lag_ms / 1000


@dataclass(frozen=True, slots=True)
class DriverSetup:
    """The setup of every driver: joints by name, limits, tick in s, command time-out in ns.

    The gripper closes with at most `grip_force_n`. `start` (n,) rad is where an arm begins that exists in its driver
    only, zeros by default; `own_range` is what the joints can measure, by default what `limits` allow.
    """

    joint_names: tuple[str, ...]
    limits: JointLimits
    dt: float
    command_timeout_ns: int
    grip_force_n: float = 25.0
    start: Array | None = None
    own_range: JointRange | None = None

    @property
    def joint_range(self) -> JointRange:
        """The range that the joints can measure."""
        limits = self.limits
        return self.own_range or JointRange(limits.lower, limits.upper, limits.velocity)


def check_joints(
    setup: DriverSetup, joints: int, arm: str = "this arm", cure: str = "give robot.model the URDF of this arm"
) -> None:
    """DriverError where the model has another number of joints than the arm."""
    if len(setup.joint_names) != joints:
        given = len(setup.joint_names)
        raise DriverError(f"{arm} has {joints} joints, the model {given}: {cure}")


class Driver(Protocol):
    """A robot, real or simulated; DriverError states why a call is refused, and no call takes longer than 50 ms.

    `configure` comes once. `activate` makes the robot take commands from rest at `q0`, where it was read; the `fault`
    of `read` shows when it does. `read` raises while nothing has been measured. `write` sends a motion that the
    driver's process has checked, and returns what was really sent; only its OPEN and CLOSED move the gripper, and no
    other call does: within `gripper_orders.ORDER_NS` or never, and not after KEEP, a stop or an activation. `stop`
    brings the robot to rest immediately and may be repeated; then only a new activation moves it. A fault that one
    reading shows is kept by the driver's process until the next activation. `deactivate` ends it all.
    """

    @property
    def capabilities(self) -> Capabilities: ...

    def configure(self, setup: DriverSetup) -> None: ...

    def activate(self, q0: Array) -> None: ...

    def read(self) -> RobotReading: ...

    def write(self, command: JointCommand) -> JointCommand: ...

    def stop(self) -> None: ...

    def deactivate(self) -> None: ...
