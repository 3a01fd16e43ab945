"""The gripper's toggles: each opening of the hand while engaged acts once, however its messages come; pure."""

from common.messages.hand import HandArm
from common.messages.robot import GripperCommand, GripperState, GripperStatus

OPPOSITE = {GripperCommand.OPEN: GripperCommand.CLOSED, GripperCommand.CLOSED: GripperCommand.OPEN}
BY_STATUS = {
    GripperStatus.OPEN: GripperCommand.CLOSED,
    GripperStatus.CLOSED: GripperCommand.OPEN,
    GripperStatus.HOLDING: GripperCommand.OPEN,
}
MOST_AT_ONCE = 64  # openings since the last sample: a hand makes fewer even while a second of samples is lost


class GripperToggles:
    """Turns the count in the hand samples into commands; toggles made while not engaged are never applied.

    Nor is the opening of a hand that was open at the engagement, at the end of a hold, under the clutch or when it came
    back into view: it has to be seen closed first.

    The `command` is KEEP from the start, and again after each activation, until a toggle gives another. What a toggle
    commands is decided in this order:

    1. A gripper measured closed or holding is opened, and one measured open is closed. Only a measurement made under
       the command in force counts: a status that the last toggle has made out of date does not.
    2. Otherwise (it moves, has timed out, is unknown or not measured) the toggle inverts the last toggle's command: the
       second of two quick toggles undoes the first, wherever the fingers are.
    3. Before the first toggle it closes.

    Several toggles that come with one sample each undo the one before, by rule 2: two of them go back and forth. More
    than MOST_AT_ONCE were made by no hand: the count is damaged or forged, moves nothing, and is a new baseline.
    """

    def __init__(self) -> None:
        self.command = GripperCommand.KEEP
        self.applied = 0
        self._toggled: GripperCommand | None = None  # by the last toggle
        self._baseline = self._revision = 0
        self._seen_closed = False

    def keep(self) -> None:
        """Leave the gripper as it is until the next toggle."""
        self.command = GripperCommand.KEEP

    def next(self, gripper: GripperState | None) -> GripperCommand:
        """Return what a toggle would command now, of a gripper in this state, None while it is not measured."""
        if gripper is not None and gripper.commanded is self.command and gripper.status in BY_STATUS:
            return BY_STATUS[gripper.status]
        return GripperCommand.CLOSED if self._toggled is None else OPPOSITE[self._toggled]

    def rebase(self, sample: HandArm, revision: int) -> None:
        """Count from this sample, as at an engagement; a hand that is open in it has to be seen closed first."""
        self._baseline, self._revision = sample.gripper_toggles, revision
        self._seen_closed = not sample.hand_open

    def interrupt(self) -> None:
        """The hand was lost, or jumped to where it cannot be: it has to be seen closed before a toggle counts."""
        self._seen_closed = False

    def follow(self, sample: HandArm, revision: int, gripper: GripperState | None) -> None:
        """Apply what has been counted since the baseline to a gripper in this state.

        `revision` is that of the operator's settings: new origins, like any change of them, are a new baseline.
        """
        count = sample.gripper_toggles
        if revision != self._revision or not self._seen_closed:
            self.rebase(sample, revision)
        toggles = count - self._baseline
        if 0 < toggles <= MOST_AT_ONCE:
            first = self.next(gripper)
            self.command = self._toggled = first if toggles % 2 else OPPOSITE[first]
            self.applied += toggles
        self._baseline = count
