"""Schedule of planned motions: when each may be written, so that late calls never exceed the robot's limits; pure."""

import math
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")

LEAST_FRACTION = 0.9  # least fraction of its planned time that a motion takes: less would exceed the limits too far
ROUNDING_NS = 1.0


class WriteScheduler(Generic[T]):
    """Motions wait here, each with its time in the plan, ns, until they may be written.

    A motion is written no sooner after the last one than nine tenths of the planned time between them. What waits
    because a call was late follows at that pace until the delay is made up; otherwise nothing waits. A robot that stays
    where it was sent last goes on from there after a pause: with `longest_ns` no motion is further on in the plan than
    that from the one before it, so the plan waits as long as nothing was written.
    """

    def __init__(self, longest_ns: int | None = None) -> None:
        self._longest_ns = longest_ns
        self._waiting: deque[tuple[int, T]] = deque()
        self._written_ns = self._planned_ns = self._extra_ns = 0

    def restart(self, planned_ns: int, now_ns: int) -> None:
        """Forget what waits; the robot rests where the plan begins."""
        self._waiting.clear()
        self._written_ns, self._planned_ns, self._extra_ns = now_ns, planned_ns, 0

    def delay(self, extra_ns: int) -> None:
        """Delay the next motion by `extra_ns` of plan time: what was written last is that far off the plan."""
        self._extra_ns = extra_ns

    def repeat(self, now_ns: int) -> None:
        """The last motion was written again: the next one takes its time from now."""
        self._written_ns = now_ns

    def add(self, planned_ns: int, motion: T) -> None:
        """Append a motion, unless one with a later plan time has been written."""
        if planned_ns > self._planned_ns:
            self._waiting.append((planned_ns, motion))

    def take(self, now_ns: int) -> T | None:
        """The newest motion that may be written now, and is; the ones before it are skipped."""
        newest, furthest_ns = None, self._furthest_ns(now_ns)
        while self._waiting and self._waiting[0][0] <= furthest_ns:
            self._planned_ns, newest = self._waiting.popleft()
            self._written_ns, self._extra_ns = now_ns, 0
        return newest

    def take_part(self, now_ns: int) -> tuple[T | None, T | None, float]:
        """As `take`, then the next motion and the fraction of the way to it that may be written now too, and is.

        Without that, whoever writes rarely would lose what is left of the time until then, and fall behind.
        """
        furthest_ns, newest = self._furthest_ns(now_ns), self.take(now_ns)
        if not self._waiting or furthest_ns <= self._planned_ns:
            return newest, None, 0.0
        following_ns, following = self._waiting[0]
        fraction = (furthest_ns - self._planned_ns) / (following_ns - self._planned_ns)
        self._planned_ns, self._written_ns, self._extra_ns = furthest_ns, now_ns, 0
        return newest, following, fraction

    def reach(self, planned_ns: int, now_ns: int) -> int:
        """Go towards a plan time as far as is allowed now, discarding what waits; the plan time that is written."""
        self._waiting.clear()
        furthest_ns = self._furthest_ns(now_ns)
        self._extra_ns = max(self._planned_ns - furthest_ns, 0)
        self._planned_ns = max(min(planned_ns, furthest_ns), self._planned_ns)
        self._written_ns = now_ns
        return self._planned_ns

    @property
    def planned_ns(self) -> int:
        """The plan time of the motion that was written last."""
        return self._planned_ns

    def waits(self, now_ns: int) -> bool:
        """Return whether the newest motion may not be written yet."""
        return bool(self._waiting) and self._waiting[-1][0] > self._furthest_ns(now_ns)

    @property
    def due_ns(self) -> int | None:
        """The time at which the next motion may be written, ns; None if none waits."""
        if not self._waiting:
            return None
        return self._written_ns + math.ceil(LEAST_FRACTION * (self._waiting[0][0] - self._planned_ns + self._extra_ns))

    def _furthest_ns(self, now_ns: int) -> int:
        further_ns = math.floor((now_ns - self._written_ns) / LEAST_FRACTION + ROUNDING_NS) - self._extra_ns
        return self._planned_ns + (further_ns if self._longest_ns is None else min(further_ns, self._longest_ns))
