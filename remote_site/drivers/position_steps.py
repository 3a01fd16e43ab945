"""Steps of joints that stay where they were sent last: none is longer than a period's motion at full speed; pure."""

import numpy as np

from common.geometry import Array

ROUNDING = 1e-5  # of a step: what arithmetic adds to one at full speed


class PositionSteps:
    """Sends joints no further at once than `most` (n,) in rad; a longer way goes straight on, in several steps.

    To be read: `q` (n,) in rad, where they were sent last.
    """

    def __init__(self, most: Array, q: Array) -> None:
        self._most, self.q = most * (1 + ROUNDING), q

    def restart(self, q: Array) -> None:
        """They are at `q` (n,) in rad."""
        self.q = q

    def towards(self, goal: Array) -> Array:
        """Return where to send them on the way to `goal` (n,) in rad: there, if it is no step too far."""
        way = goal - self.q
        times = float((np.abs(way) / self._most).max())
        self.q = goal if times <= 1.0 else self.q + way / times
        return self.q
