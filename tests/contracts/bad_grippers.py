"""A kinematic robot with a gripper, and drivers that do not keep what it holds, each in one thing."""

from dataclasses import replace

from common.clock import FakeClock
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import Capabilities, GripperReading, JointCommand, RobotReading
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
