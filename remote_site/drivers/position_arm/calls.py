"""The calls of an arm's methods: when they are due, what comes of them, and which of them has failed."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from common.clock import NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.gripper_orders import GripperOrders
from remote_site.drivers.position_arm.arm import MeasuredPositions, PositionArm, PositionArmWithGripper, Positions
from remote_site.drivers.position_steps import PositionSteps

T = TypeVar("T")


class ArmCallError(Exception):
    """A method of an arm raised, or returned what it must not; the text names it."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """Positions (n,) in rad measured at `t_ns`, and the gripper's opening in m, None where it was not measured."""

    t_ns: int
    q: Array
    opening_m: float | None


class Calls(Protocol):
    """The calls by which a driver has its arm do something.

    `obeyed` is the number of the last command that was written since `begin`, None before; `sent` (n,) in rad is where
    the arm was sent last, in whatever activation. `begin` comes before the first command of an activation, where the
    arm is at `q` (n,) rad and hangs `hang` (n,) rad from where it was sent, which is added to all positions; from there
    none is further than `most_rad` (n,) from the one before it. `withdraw_grip`: what the gripper was ordered and does
    not do yet, it will not do; neither does it after a stop. `measure`, called in every turn, returns what has newly
    been measured, or None; it repeats a stop that has failed until one succeeds. `end` comes last: it stops the arm if
    told to, and lets go of it.
    """

    @property
    def obeyed(self) -> int | None: ...

    @property
    def sent(self) -> Array | None: ...

    def begin(self, q: Array, hang: Array, most_rad: Array, most_n: float) -> None: ...

    def measure(self) -> Measurement | None: ...

    def write(self, command: JointCommand) -> None: ...

    def withdraw_grip(self) -> None: ...

    def stop(self) -> None: ...

    def end(self, *, stops: bool) -> None: ...


class ArmCalls:
    """`Calls` that are made on the spot, in the thread that asks for them.

    `under_way` is the method that is running and since when, in ns; any thread may read it.
    """

    def __init__(self, arm: PositionArm, clock: Clock) -> None:
        self._arm, self._clock = arm, clock
        self._period_ns = round(NS_PER_S / arm.rate_hz)
        self._due_ns = 0
        self._owes_stop = False
        self._steps: PositionSteps | None = None
        self._hang = np.zeros(arm.joints)
        self.sent: Array | None = None
        self._gripper, self._most_n = GripperOrders(), 0.0
        self.obeyed: int | None = None
        self.under_way: tuple[str, int] | None = None

    @property
    def due_ns(self) -> int:
        """The time at which the arm is to be read again, ns."""
        return self._due_ns

    @property
    def _kind(self) -> str:
        """The class of the arm, which its author knows."""
        return type(self._arm).__name__

    def begin(self, q: Array, hang: Array, most_rad: Array, most_n: float) -> None:
        """Nothing has been commanded; the gripper, too, keeps what it does. `most_n` is its largest force.

        DriverError while a stop has not succeeded.
        """
        if self._owes_stop:
            raise DriverError("the arm has not been stopped yet")
        self.withdraw_grip()
        self._hang, self._steps = hang, PositionSteps(most_rad, q + hang)
        self.obeyed, self._most_n = None, most_n

    def measure(self) -> Measurement | None:
        """Read the arm once a period."""
        now_ns = self._clock.now_ns()
        if now_ns < self._due_ns:
            return None
        self._due_ns = now_ns + self._period_ns - (now_ns - self._due_ns) % self._period_ns
        if self._owes_stop:
            self.stop()
        return self._measured(now_ns)

    def write(self, command: JointCommand) -> None:
        """Send the arm to a command's positions, and the gripper if the command has changed."""
        self.note_grip(command)
        self.send(command)

    def note_grip(self, command: JointCommand) -> None:
        """Note what the gripper is ordered, for the next `send`; any thread may."""
        self._gripper.note(command.gripper, command.t_ns)

    def withdraw_grip(self) -> None:
        """Forget what the gripper was ordered; any thread may, also while the arm is being sent somewhere."""
        self._gripper.withdraw()

    def send(self, command: JointCommand) -> None:
        """Send the arm to a command's positions, and then have the gripper do what is ordered by now.

        After a pause, as of a thread whose last call was slow, they are too far for one step: it gets there in several.
        """
        goal = command.q + self._hang
        self.sent = goal if self._steps is None else self._steps.towards(goal)
        positions = np.array(self.sent)  # the arm may keep it, and write to it
        self._call("write", lambda: self._arm.write(positions))
        self.obeyed = command.seq
        self._grip(self._gripper.take(self._clock.now_ns()))

    def stop(self) -> None:
        """Stop the arm."""
        self.withdraw_grip()
        self._owes_stop = True
        self._call("stop", self._arm.stop)
        self._owes_stop = False

    def end(self, *, stops: bool) -> None:
        """Stop the arm if told to, and let go of it, also where the stop fails."""
        try:
            if stops:
                self.stop()
        finally:
            self._call("close", self._arm.close)

    def _measured(self, now_ns: int) -> Measurement | None:
        given = self._call("read", self._arm.read)
        if given is None:
            return None
        stamped = given if isinstance(given, MeasuredPositions) else MeasuredPositions(given, now_ns)
        return Measurement(stamped.t_ns, self._checked(stamped.q), self._opening_m())

    def _checked(self, given: Positions) -> Array:
        """An array of its own, of the right length."""
        expected = f"{self._arm.joints} positions in rad are expected"
        try:
            positions: Array = np.array(given, dtype=float)
        except (TypeError, ValueError) as error:
            raise ArmCallError(f"{self._kind}.read returned {type(given).__name__}, {expected}: {error}") from error
        if positions.shape != (self._arm.joints,):
            raise ArmCallError(f"{self._kind}.read returned positions of the shape {positions.shape}, {expected}")
        return positions

    def _opening_m(self) -> float | None:
        arm = self._arm
        if not isinstance(arm, PositionArmWithGripper):
            return None
        return self._call("gripper_opening_m", arm.gripper_opening_m)

    def _grip(self, command: GripperCommand) -> None:
        arm = self._arm
        if not isinstance(arm, PositionArmWithGripper):
            return
        if command is GripperCommand.OPEN:
            self._call("open_gripper", arm.open_gripper)
        elif command is GripperCommand.CLOSED:
            self._call("close_gripper", lambda: arm.close_gripper(self._most_n))

    def _call(self, method: str, call: Callable[[], T]) -> T:
        name = f"{self._kind}.{method}"
        self.under_way = name, self._clock.now_ns()
        try:
            return call()
        except DriverError:
            raise  # it is a sentence of the author's
        except Exception as error:  # a robot's library may raise anything
            raise ArmCallError(f"{name} raised {type(error).__name__}: {error}") from error
        finally:
            self.under_way = None
