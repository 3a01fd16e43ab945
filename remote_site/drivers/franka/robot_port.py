"""The driver's port to libfranka: states, a motion that is fed each millisecond, the gripper; and how they fail."""

from dataclasses import dataclass
from typing import Protocol

from common.errors import DriverError
from common.geometry import Array


class LinkLostError(DriverError):
    """The robot does not answer, or no longer."""


class UnreachableError(LinkLostError):
    """There is no connection; the text is the whole sentence, with the address and the cure."""


class MotionAbortedError(DriverError):
    """The robot has broken off a motion; its next state has the errors."""


class RobotRefusedError(DriverError):
    """The robot does not do what was asked."""


@dataclass(frozen=True, slots=True)
class ArmState:
    """The arm as its controller reports it at `t_ns` of its own time, in whole ms.

    `q` rad and `dq` rad/s are measured, `held` rad is where the controller wants the joints, all (7,). `mode` and
    `errors` (of now, and of the last motion) are libfranka's names.
    """

    t_ns: int
    q: Array
    dq: Array
    held: Array
    mode: str
    errors: tuple[str, ...]
    motion_errors: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class GripperWidth:
    """The gripper: the opening between its fingers and the widest one, m."""

    opening_m: float
    widest_m: float


class MotionPort(Protocol):
    """A motion under way: `read` waits for the robot's next millisecond, `write` answers it."""

    def read(self) -> ArmState: ...

    def write(self, q: Array, *, finished: bool) -> None: ...


class RobotPort(Protocol):
    """A connection to the robot: a state each millisecond, a motion, and the recovery from errors."""

    def read(self) -> ArmState: ...

    def start(self) -> MotionPort: ...

    def recover(self) -> None: ...


class GripperPort(Protocol):
    """A connection to the gripper's server; `open` and `close` wait for the fingers, and say whether all went well."""

    def read(self) -> GripperWidth: ...

    def open(self, width_m: float, speed_m_s: float) -> bool: ...

    def close(self, speed_m_s: float, force_n: float) -> bool: ...
