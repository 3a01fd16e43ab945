"""What a robot driver is: configure, activate, (read, write)*, stop, deactivate."""

from dataclasses import dataclass
from typing import Protocol

from common.geometry import Array
from common.messages import GripperState
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits


@dataclass(frozen=True, slots=True)
class JointCommand:
    """What the robot shall do by the next tick: joints in rad, rad/s, rad/s² in the model's order, and the gripper.

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
class RobotReading:
    """The robot as measured at `t_ns`: joints in rad and rad/s, the gripper if there is one.

    `ready` is False, with the reason in `fault`, while the robot cannot take commands. `obeyed_seq` is the newest
    command that has reached the robot's motion, None before the first.
    """

    t_ns: int
    q: Array
    dq: Array
    gripper: GripperState | None
    ready: bool
    fault: str
    obeyed_seq: int | None


@dataclass(frozen=True, slots=True)
class DriverSetup:
    """What every driver is told before it starts: joints by name, limits, tick in s, command time-out in ns."""

    joint_names: tuple[str, ...]
    limits: JointLimits
    dt: float
    command_timeout_ns: int


class Driver(Protocol):
    """A robot, real or simulated; no call ever waits, and DriverError says why a call is refused.

    `configure` comes once, `activate` makes the robot take commands from rest at `q0`, `write` returns the command that
    was really sent, `stop` executes the jerk-limited stop at once and may be repeated, `deactivate` ends it for good.
    When commands cease for longer than the time-out, the driver executes the stop by itself.
    """

    def configure(self, setup: DriverSetup) -> None: ...

    def activate(self, q0: Array) -> None: ...

    def read(self) -> RobotReading: ...

    def write(self, command: JointCommand) -> JointCommand: ...

    def stop(self) -> None: ...

    def deactivate(self) -> None: ...
