"""Announcements of a run at the terminal as it changes, but no flood of them; pure."""

from collections.abc import Callable

from common.clock import NS_PER_S

APART_NS = NS_PER_S // 2


class Announcements:
    """Passes words on to `tell` when they change, at most twice a second; the last ones always come in the end."""

    def __init__(self, tell: Callable[[str], object]) -> None:
        self._tell = tell
        self._told, self._told_ns = "", -APART_NS

    def offer(self, words: str, now_ns: int) -> None:
        """Announce what holds now if it has changed, but not too often; to be called again and again."""
        if words != self._told and now_ns - self._told_ns >= APART_NS:
            self._told, self._told_ns = words, now_ns
            self._tell(words)
