"""Offset that the target lacks of the hand's motion after a short hold: kept, and made up slowly; pure."""

import math

import numpy as np

from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from remote_site.motion.catch_up import CATCH_UP_M_S, CATCH_UP_RAD_S

MOST_M, MOST_RAD = 0.03, math.radians(10.0)
FULL_S = 0.8  # from the greatest offset to none at the greatest speed, which is slower than the tool may catch up
RAMP_S = 0.25  # until the target moves at the greatest speed
SLOW_FRACTION = 0.3  # of the greatest offset, from which on it slows down again


class HoldOffset:
    """The offset of the target from where its origins put it: a way (3,) in m and a turn (3,) in rad, base axes."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Nothing is lacking: new origins were taken."""
        self._way, self._turn, self._elapsed_s = np.zeros(3), np.zeros(3), 0.0
        self.spare = 1.0  # the fraction of the catch-up speed that the target did not need for its last step

    def begin(self, base_T_origins: Array, base_T_tool: Array) -> bool:
        """Lead the target from the tool, where it rests, to where the origins put it; False where that is too far."""
        way = base_T_tool[:3, 3] - base_T_origins[:3, 3]
        turn = vector_from_rotation(base_T_tool[:3, :3] @ base_T_origins[:3, :3].T)
        near = math.hypot(*way) <= MOST_M and math.hypot(*turn) <= MOST_RAD
        if near:
            self._way, self._turn, self._elapsed_s = way, turn, 0.0
        return near

    def apply(self, base_T_origins: Array, elapsed_s: float) -> Array:
        """The target (4 x 4), `elapsed_s` after the last one."""
        if not (self._way.any() or self._turn.any()):
            self.spare = 1.0
            return base_T_origins
        self._elapsed_s += elapsed_s
        speed = min(self._elapsed_s / RAMP_S, 1.0) / FULL_S
        step = speed * elapsed_s
        self.spare = 1.0 - speed * max(MOST_M / CATCH_UP_M_S, MOST_RAD / CATCH_UP_RAD_S)
        self._way = MOST_M * shortened(self._way / MOST_M, step)
        self._turn = MOST_RAD * shortened(self._turn / MOST_RAD, step)
        rotation = rotation_from_vector(self._turn) @ base_T_origins[:3, :3]
        return transform(rotation, base_T_origins[:3, 3] + self._way)


def shortened(vector: Array, step: float) -> Array:
    """A vector, of length 1 at most, shortened by a step that becomes smaller towards its end."""
    length = math.hypot(*vector)
    by = step * min(max(length / SLOW_FRACTION, 0.1), 1.0)
    return vector * ((length - by) / length) if length > by else np.zeros(3)
