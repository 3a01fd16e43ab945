"""Orders to the gripper: each change of its command is one, to be carried out within a second or never; pure."""

from dataclasses import dataclass

from common.clock import NS_PER_S
from common.messages.robot import GripperCommand

ORDER_NS = NS_PER_S  # how long an order may wait for a gripper that is busy, or whose link is down


@dataclass(frozen=True, slots=True)
class GripperOrder:
    """To open or to close, no later than `until_ns`."""

    gripper: GripperCommand
    until_ns: int


class GripperOrders:
    """Makes orders of the gripper's command, which comes with every motion; the newest counts, and each only once.

    One thread may note and withdraw them while another carries them out.
    """

    def __init__(self) -> None:
        self._newest: GripperOrder | None = None
        self._taken: GripperOrder | None = None

    def note(self, gripper: GripperCommand, t_ns: int) -> GripperOrder | None:
        """The order that this command of `t_ns` is, None for KEEP, and where it only repeats the last order."""
        if gripper is GripperCommand.KEEP or (self._newest is not None and gripper is self._newest.gripper):
            return None
        self._newest = GripperOrder(gripper, t_ns + ORDER_NS)
        return self._newest

    def withdraw(self) -> None:
        """Nothing that was ordered is carried out any more, and the same command is a new order."""
        self._newest = None

    def take(self, now_ns: int) -> GripperCommand:
        """What is to be carried out now; KEEP where there is nothing, or where it is too late."""
        order = self._newest
        if order is None or order is self._taken:
            return GripperCommand.KEEP
        self._taken = order
        return order.gripper if now_ns <= order.until_ns else GripperCommand.KEEP
