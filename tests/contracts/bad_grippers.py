"""A kinematic robot with a gripper, and drivers that do not keep what it holds, each in one thing."""

from dataclasses import replace

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import Capabilities, GripperReading, JointCommand, RobotReading
from remote_site.drivers.gripper_orders import GripperOrders
from remote_site.drivers.kinematic import KinematicDriver

OPENING_M = {GripperCommand.OPEN: 0.06, GripperCommand.CLOSED: 0.0}
HOLDING_M = 0.02


class Gripping(KinematicDriver):
    """Its gripper is at once where it is commanded, and outlives the driver, as that of a robot does."""

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(clock)
        self.opening_m = vars(clock).setdefault("opening_m", [HOLDING_M])

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(1000.0, None, gripper=True, force=False, watchdog_ms=None)

    def read(self) -> RobotReading:
        return replace(super().read(), gripper=GripperReading(self.opening_m[0], None))

    def write(self, command: JointCommand) -> JointCommand:
        sent = super().write(command)
        self.grip(command.gripper)
        return sent

    def grip(self, command: GripperCommand) -> None:
        if command in OPENING_M:
            self.opening_m[0] = OPENING_M[command]


class Clenched(Gripping):
    """Never moves its gripper."""

    def grip(self, command: GripperCommand) -> None:
        pass


class Opener(Gripping):
    """Takes KEEP for OPEN."""

    def grip(self, command: GripperCommand) -> None:
        super().grip(GripperCommand.OPEN if command is GripperCommand.KEEP else command)


class Closer(Gripping):
    """Takes KEEP for CLOSED."""

    def grip(self, command: GripperCommand) -> None:
        super().grip(GripperCommand.CLOSED if command is GripperCommand.KEEP else command)


class Welcoming(Gripping):
    """Opens its gripper in every activation."""

    def activate(self, q0: Array) -> None:
        super().activate(q0)
        self.grip(GripperCommand.OPEN)


class Releasing(Gripping):
    """Opens its gripper in every stop."""

    def stop(self) -> None:
        super().stop()
        self.grip(GripperCommand.OPEN)


class Unhurried(Gripping):
    """Its gripper obeys 30 ms after its order, at 0.2 m/s: a good one, that forgets what it should."""

    wait_ns = 30 * NS_PER_MS

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(clock)
        self.goal_m, self.moved_ns = self.opening_m[0], clock.now_ns()
        self.orders, self.ordered_ns = GripperOrders(), 0

    def activate(self, q0: Array) -> None:
        super().activate(q0)
        self.forget()

    def stop(self) -> None:
        super().stop()
        self.forget()

    def forget(self) -> None:
        self.orders.withdraw()

    def grip(self, command: GripperCommand) -> None:
        now_ns = self._clock.now_ns()
        if self.orders.note(command, now_ns) is not None:
            self.ordered_ns = now_ns

    def read(self) -> RobotReading:
        now_ns = self._clock.now_ns()
        most_m = 0.2 * (now_ns - self.moved_ns) / NS_PER_S
        self.opening_m[0] += float(np.clip(self.goal_m - self.opening_m[0], -most_m, most_m))
        self.moved_ns = now_ns
        if self._obeyed is not None and self._stop_ns is None and now_ns - self.ordered_ns >= self.wait_ns:
            self.obey(now_ns)
        return super().read()

    def obey(self, now_ns: int) -> None:
        self.goal_m = OPENING_M.get(self.orders.take(now_ns), self.goal_m)


class Stubborn(Unhurried):
    """KEEP withdraws nothing that its gripper was ordered: good where nothing waits for longer than it may."""

    def grip(self, command: GripperCommand) -> None:
        if command is not GripperCommand.KEEP:
            super().grip(command)


class Postponing(Stubborn):
    """Does after an activation what its gripper was ordered before."""

    def forget(self) -> None:
        pass


class Patient(Stubborn):
    """Does what its gripper was ordered however long ago."""

    def obey(self, now_ns: int) -> None:
        super().obey(min(now_ns, self.ordered_ns))
