"""Which changes of the session's state a log shows: each at once, but of engaged and holding one a second; pure."""

from common.clock import NS_PER_S
from common.messages.robot import FOLLOWING, SessionState

APART_NS = NS_PER_S  # a poor hand or link makes the arm hold and follow many times a second


class StateLines:
    """Counts the changes of the state; several between engaged and holding share a line."""

    def __init__(self) -> None:
        self._seen: SessionState | None = None
        self._shown: SessionState | None = None
        self._shown_ns = 0
        self._changes = 0

    def note(self, state: SessionState, now_ns: int) -> int:
        """Note the state now; how many changes a line that is due now stands for, 0 while none is."""
        if state is not self._seen:
            self._seen, self._changes = state, self._changes + 1
        waits = state in FOLLOWING and self._shown in FOLLOWING and now_ns - self._shown_ns < APART_NS
        if waits or not self._changes:
            return 0
        changes, self._changes = self._changes, 0
        self._shown, self._shown_ns = state, now_ns
        return changes


def counted(changes: int) -> dict[str, int]:
    """The field of a line that stands for more than one change."""
    return {"changes": changes} if changes > 1 else {}
