"""The key A, which the operator holds where the page offers to lead the tool to what the step under way is for."""

from enum import Enum

from common.messages.robot import AssistPhase, AssistState

THERE = "assist_there"
PATIENCE_S = 1.0  # for the page to show that a press or a release was heard


class Led(Enum):
    """Who brings the tool to the step's goal: the hand, the robot, or the robot has."""

    BY_HAND = "by hand"
    BY_ROBOT = "by robot"
    THERE = "there"


class AssistKey:
    """The key A; `held` is the target's name that it is held for, None while it is not.

    It is pressed a reaction after the page offered the wanted target, and held until another step wants another, or
    the page shows that the robot leads no more.
    """

    def __init__(self, reaction_s: float) -> None:
        self.held: str | None = None
        self._reaction_s = reaction_s
        self._press_s: float | None = None
        self._changed_s = 0.0

    def see(self, state: AssistState | None, wanted: str | None, now_s: float) -> Led:
        """Take what the page shows of the assist at a time, and who brings the tool where it is wanted."""
        if self.held is not None:
            return self._hold(state, wanted, now_s)
        if _offered(state) != wanted or wanted is None or now_s - self._changed_s < PATIENCE_S:
            self._press_s = None
            return Led.BY_HAND
        if self._press_s is None:
            self._press_s = now_s + self._reaction_s
        if now_s >= self._press_s:
            self.held, self._changed_s = wanted, now_s
        return Led.BY_ROBOT

    def let_go(self, now_s: float) -> None:
        """Release the key."""
        if self.held is not None:
            self.held, self._press_s, self._changed_s = None, None, now_s

    def _hold(self, state: AssistState | None, wanted: str | None, now_s: float) -> Led:
        leading = state if state is not None and state.phase is AssistPhase.LEADING else None
        if self.held != wanted or (leading is None and now_s - self._changed_s > PATIENCE_S):
            self.let_go(now_s)
            return Led.BY_HAND
        return Led.THERE if leading is not None and leading.code == THERE else Led.BY_ROBOT


def _offered(state: AssistState | None) -> str | None:
    """The name of the offered target, None without an offer."""
    if state is None or state.target is None or state.phase is not AssistPhase.OFFERED:
        return None
    return state.target.name
