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
        self._begun: GripperOrder | None = None
        self._in_time = False

    def note(self, gripper: GripperCommand, t_ns: int) -> GripperOrder | None:
        """The order that this command of `t_ns` is, None where it repeats the last order; KEEP withdraws that."""
        if gripper is GripperCommand.KEEP:
            self.withdraw()
            return None
        if self._newest is not None and gripper is self._newest.gripper:
            return None
        self._newest = GripperOrder(gripper, t_ns + ORDER_NS)
        return self._newest

    def withdraw(self) -> bool:
        """Begin nothing that was ordered, so that the same command is a new order; whether there was an order."""
        newest, self._newest = self._newest, None
        return newest is not None

    def take(self, now_ns: int) -> GripperCommand:
        """Take what is to be begun now; KEEP where there is nothing, or where it is too late."""
        order = self._newest
        if order is None or order is self._begun:
            return GripperCommand.KEEP
        self._begun, self._in_time = order, now_ns <= order.until_ns
        return order.gripper if self._in_time else GripperCommand.KEEP

    @property
    def standing(self) -> GripperCommand:
        """The last order for as long as it stands, KEEP until it is begun, and where it came too late."""
        order = self._newest
        stands = order is not None and order is self._begun and self._in_time
        return order.gripper if order is not None and stands else GripperCommand.KEEP
