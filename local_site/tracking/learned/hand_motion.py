"""How the hand moves: where its landmarks are expected, from the last two instants."""

import numpy as np

from common.geometry import Array
from local_site.tracking.tracker import extrapolation

MOST_STEP_M = 0.02  # of any landmark between two instants, up to which it is expected well enough


class HandMotion:
    """Expects landmarks (21, 3) in m at constant velocity."""

    def __init__(self) -> None:
        self._last: tuple[int, Array] | None = None
        self._before: tuple[int, Array] | None = None

    def add(self, t_ns: int, landmarks: Array) -> None:
        """Take the landmarks (21, 3) in m of an instant."""
        self._before, self._last = self._last, (t_ns, landmarks)

    def forget(self) -> None:
        """Expect nothing until two instants are known again."""
        self._last = self._before = None

    def expected(self, t_ns: int) -> tuple[Array, Array] | None:
        """The landmarks (21, 3) in m at the last instant and now; None where they are unknown or move fast."""
        if self._last is None or self._before is None:
            return None
        (last_ns, last), (before_ns, before) = self._last, self._before
        step = extrapolation(t_ns, last_ns, before_ns) * (last - before)
        is_fast = t_ns <= last_ns or float(np.max(np.sum(step * step, axis=1))) > MOST_STEP_M**2
        return None if is_fast else (last, last + step)
