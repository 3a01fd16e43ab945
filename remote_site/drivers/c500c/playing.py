"""The emulated controller's play of its queue: a setpoint a period, smooth, reversing only at setpoints; pure."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from common.geometry import Array

MOST_QUEUED = 2
PHASE = 0.2  # of a segment: when the next setpoint should come, so that it may be late by the rest
HASTE = 0.02  # by how much a segment is shorter or longer, to keep that phase although two clocks differ


@dataclass(frozen=True, slots=True)
class Segment:
    """A cubic from `q0` with velocity `v0` to `q1` with `v1`, `period` s long; all (n,)."""

    q0: Array
    v0: Array
    q1: Array
    v1: Array
    period: float

    def at(self, t: float) -> tuple[Array, Array]:
        """Position and velocity `t` s after its begin."""
        T, u = self.period, t / self.period
        step = self.q1 - self.q0
        q = self.q0 + T * self.v0 * u * (1 - u) ** 2 + step * u * u * (3 - 2 * u) - T * self.v1 * u * u * (1 - u)
        dq = self.v0 * (1 - u) * (1 - 3 * u) + step / T * 6 * u * (1 - u) + self.v1 * u * (3 * u - 2)
        return q, dq


@dataclass
class Player:
    """Plays setpoints from rest at `q`; `queue` holds those that wait, `begun` the number of the one under way."""

    q: Array
    period: float
    dq: Array = field(init=False)
    queue: deque[tuple[int, Array]] = field(default_factory=deque)
    begun: int = 0
    _segment: Segment | None = None
    _elapsed: float = 0.0
    _waited: float = 0.0
    _came_at: float = PHASE

    def __post_init__(self) -> None:
        self.dq = np.zeros(len(self.q))

    def add(self, count: int, q: Array) -> bool:
        """Queue a setpoint; False when there is no room."""
        if len(self.queue) >= MOST_QUEUED:
            return False
        self.queue.append((count, q))
        self._came_at = self._elapsed / self.period if self._segment is not None else PHASE
        return True

    def tick(self, dt: float) -> bool:
        """Advance by `dt` s; False when the queue ran dry in full motion."""
        self._elapsed += dt
        segment = self._segment
        if segment is not None and self._elapsed >= segment.period - 1e-9:
            self._elapsed -= segment.period
            self.q, self.dq, self._segment = segment.q1, segment.v1, None
            if not self.queue and self.dq.any():
                return False
        if self._segment is None:
            self._begin(dt, running=segment is not None)
        if self._segment is not None:
            self.q, self.dq = self._segment.at(self._elapsed)
        return True

    def _begin(self, dt: float, *, running: bool) -> None:
        """Take the next setpoint, from rest only when it has waited long enough for others to be there."""
        if not self.queue:
            self._waited = 0.0
            return
        self._waited += dt
        if not running and self._waited < (2 - PHASE) * self.period:
            return
        self._elapsed = self._elapsed if running else 0.0
        self._waited = 0.0
        self.begun, goal = self.queue.popleft()
        period = self.period * (1 + HASTE * min(max((self._came_at - PHASE) / PHASE, -1.0), 1.0))
        slope = (goal - self.q) / period
        after = (self.queue[0][1] - goal) / period if self.queue else slope
        self._segment = Segment(self.q, self.dq, goal, _between(slope, after), period)


def _between(before: Array, after: Array) -> Array:
    """The velocity where two slopes meet, such that the path reverses only at setpoints (harmonic mean)."""
    same = before * after > 0
    total = np.where(same, before + after, 1.0)
    velocity: Array = np.where(same, 2 * before * after / total, 0.0)
    return velocity
