"""The interface of an arm that takes positions, for a driver's author: three methods, and three more for a gripper."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from common.geometry import Array
from remote_site.drivers.driver import DriverSetup

Positions = Sequence[float] | Array


@dataclass(frozen=True, slots=True)
class MeasuredPositions:
    """Joint positions (n,) in rad, and when the robot measured them, in ns by the clock of the `DriverHost`."""

    q: Positions
    t_ns: int


class PositionArm(ABC):
    """An arm that goes to the joint positions that were written last, and holds them when nothing more is written.

    Positions (n,) are in rad, in the order of the model's joints. `PositionArmDriver` makes it a driver, and calls the
    methods one at a time; what they raise stops the arm and is shown with the method's name. The attributes are of the
    class, or set in `__init__`.

    `joints`: how many it has. `rate_hz`: how often a second it takes positions, and is read. `lag_ms`: how much later
    it is where it was sent, at full speed, at most. `speed_over_ms`: the time over which positions are differenced.
    `writes_stop`: it has no command that brakes, so the driver writes it the positions of a stop, and then calls
    `stop`. `threaded`: `read` and `write` take more than 5 ms together, so a thread of their own calls them.
    """

    joints: int
    rate_hz: float = 50.0
    lag_ms: float = 100.0
    speed_over_ms: float = 100.0
    writes_stop: bool = False
    threaded: bool = False

    @abstractmethod
    def read(self) -> Positions | MeasuredPositions | None:
        """Read where the joints are measured now; None while there is no newer measurement than at the last call.

        Positions alone are stamped with the time just before this call. So where a library hands out what it has
        received before, return `MeasuredPositions`, or None unless something new has come. Raise DriverError while
        the robot cannot be measured; never return what was written.
        """

    @abstractmethod
    def write(self, positions: Array) -> None:
        """Send the arm to `positions` (n,) in rad, without waiting until it is there; never called by an activation."""

    @abstractmethod
    def stop(self) -> None:
        """Bring the arm to rest where it is, at once, within its limits; also called again, and at rest."""

    def configure(self, setup: DriverSetup) -> None:  # noqa: B027  # few arms need it
        """Called once, first: connect here. `setup` has the names and the limits of the joints. By default nothing."""

    def close(self) -> None:  # noqa: B027  # as above
        """Called once, last, also where `configure` has failed: let go of the line to the robot. By default nothing."""


class PositionArmWithGripper(PositionArm):
    """The same with a gripper, which is opened and closed only when the operator toggles it."""

    @abstractmethod
    def open_gripper(self) -> None:
        """Begin to open the gripper, without waiting."""

    @abstractmethod
    def close_gripper(self, most_n: float) -> None:
        """Begin to close the gripper with at most this force in N, without waiting."""

    @abstractmethod
    def gripper_opening_m(self) -> float | None:
        """The measured opening between the fingers in m; None while it cannot be measured."""
