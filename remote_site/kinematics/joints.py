"""The motion of the joints at one instant, as planned, checked and sent."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from common.geometry import Array


@dataclass(frozen=True, slots=True)
class JointMotion:
    """Positions (n,) in rad, velocities in rad/s and accelerations in rad/s² in the order of the model's joints."""

    q: Array
    dq: Array
    ddq: Array

    @classmethod
    def at_rest(cls, q: Array) -> Self:
        """Standing still at `q`."""
        return cls(np.array(q, dtype=float), np.zeros(len(q)), np.zeros(len(q)))

    @property
    def finite(self) -> bool:
        """No NaN and no infinity anywhere."""
        return math.isfinite(sum(self.q.tolist()) + sum(self.dq.tolist()) + sum(self.ddq.tolist()))

    @property
    def resting(self) -> bool:
        """Neither velocity nor acceleration."""
        return not (any(self.dq.tolist()) or any(self.ddq.tolist()))
