"""No motion reaches the robot faster than it was planned, whatever the calls before it took; pure."""

import math
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")

# Of its time as planned that a motion takes at least: sooner, the robot would see more than the limits.
LEAST_SHARE = 0.9
ROUNDING_NS = 1.0


class WriteScheduler(Generic[T]):
    """Motions wait here, each with its time in the plan, ns, until they may be written.

    A motion planned for so much later than the one written last is written no sooner than nine tenths of that after it.
    What waits because a call was late follows at that pace until the delay is made up; otherwise nothing waits.
    """

    def __init__(self) -> None:
        self._waiting: deque[tuple[int, T]] = deque()
        self._written_ns = self._planned_ns = self._owed_ns = 0

    def restart(self, planned_ns: int, now_ns: int) -> None:
        """Forget what waits; the robot rests where the plan begins."""
        self._waiting.clear()
        self._written_ns, self._planned_ns, self._owed_ns = now_ns, planned_ns, 0

    def owe(self, planned_ns: int) -> None:
        """What was written last differs from the plan as much as so much of it: the next waits for that, too."""
        self._owed_ns = planned_ns

    def repeat(self, now_ns: int) -> None:
        """What was written last was written again: the robot leaves it no sooner than a motion's time after this."""
        self._written_ns = now_ns

    def add(self, planned_ns: int, motion: T) -> None:
        """A motion to be written after all that wait, unless what is planned for later has been written."""
        if planned_ns > self._planned_ns:
            self._waiting.append((planned_ns, motion))

    def take(self, now_ns: int) -> T | None:
        """The newest motion that may be written now, and is; those before it are left out."""
        newest, furthest_ns = None, self._furthest_ns(now_ns)
        while self._waiting and self._waiting[0][0] <= furthest_ns:
            self._planned_ns, newest = self._waiting.popleft()
            self._written_ns, self._owed_ns = now_ns, 0
        return newest

    def reach(self, planned_ns: int, now_ns: int) -> int:
        """How far in the plan a motion on the way there, beyond all that wait, may be now; it counts as written."""
        self._waiting.clear()
        furthest_ns = self._furthest_ns(now_ns)
        self._owed_ns = max(self._planned_ns - furthest_ns, 0)
        self._planned_ns = max(min(planned_ns, furthest_ns), self._planned_ns)
        self._written_ns = now_ns
        return self._planned_ns

    @property
    def planned_ns(self) -> int:
        """How far in the plan the motion is that was written last."""
        return self._planned_ns

    def waits(self, now_ns: int) -> bool:
        """Whether there is anything that may not be written yet."""
        return bool(self._waiting) and self._waiting[-1][0] > self._furthest_ns(now_ns)

    @property
    def due_ns(self) -> int | None:
        """When the next motion may be written; None if none waits."""
        if not self._waiting:
            return None
        return self._written_ns + math.ceil(LEAST_SHARE * (self._waiting[0][0] - self._planned_ns + self._owed_ns))

    def _furthest_ns(self, now_ns: int) -> int:
        return self._planned_ns - self._owed_ns + math.floor((now_ns - self._written_ns) / LEAST_SHARE + ROUNDING_NS)
