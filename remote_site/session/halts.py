"""Halts: who has stopped the arm and what has failed since the last reset, and when the newest of it came; pure."""

from common.messages.base import MOST_TEXT
from common.text import cut
from remote_site.reasons import Code, Reason, reason

MOST_NAMED = 3  # of those who have stopped the arm; more would not fit into the sentence


class Halts:
    """The halts that only a reset clears, in one `reason`, which names the newest who stopped the arm first.

    `newest_ns` is when the newest halt came, by the clock of the ticks: 0 before the first. It also rises with what
    needs no reset and ends an engagement all the same. Whoever resets or engages has to name it, so that nothing is
    cleared or outlived that they were not shown; no two halts have the same one, over restarts of the site either.
    """

    def __init__(self) -> None:
        self.newest_ns = 0
        self.reason: Reason | None = None
        self._stoppers: list[str] = []
        self._cause = ""

    def stop(self, who: str, now_ns: int) -> Reason:
        """Somebody has stopped the arm; the reason as it is now."""
        self._stoppers = [who, *(other for other in self._stoppers if other != who)][: MOST_NAMED + 1]
        return self._halt(now_ns)

    def fail(self, cause: str, now_ns: int) -> Reason:
        """The robot or a part of the remote site has failed; the reason as it is now."""
        self._cause = cause
        return self._halt(now_ns)

    def note(self, now_ns: int) -> None:
        """An engagement was ended by request, or the robot has stopped by itself: no reset is due for that alone."""
        self.newest_ns = now_ns

    def clear(self) -> None:
        """Everything is reset."""
        self._stoppers, self._cause, self.reason = [], "", None

    def unseen(self, seen_ns: int, act: str, now: str) -> Reason | None:
        """Say why who was shown the halt at `seen_ns` may not `act`, None if it is the newest; `now` says what is."""
        if seen_ns == self.newest_ns:
            return None
        return reason(Code.UNSEEN, act=act, now=cut(now, _room(Code.UNSEEN, act=act, now="")))

    def _halt(self, now_ns: int) -> Reason:
        self.newest_ns = now_ns
        if not self._cause:
            self.reason = reason(Code.STOPPED, operator=self._named())
            return self.reason
        stopped = f"stopped by {self._named()}; " if self._stoppers else ""
        self.reason = reason(Code.FAULT, cause=cut(stopped + self._cause, _room(Code.FAULT, cause="")))
        return self.reason

    def _named(self) -> str:
        others = ["others"] if len(self._stoppers) > MOST_NAMED else []
        *names, last = [*self._stoppers[:MOST_NAMED], *others]
        return f"{', '.join(names)} and {last}" if names else last


def _room(code: Code, **values: str) -> int:
    """Return how many characters a message leaves to what fills a sentence."""
    return MOST_TEXT - len(reason(code, **values).sentence)
