"""The way of a scripted hand: a smooth glide to a place and a turn, and a circle around it; pure."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array

PHASES = np.array([1.0, 0.5, 1.5])


@dataclass(frozen=True)
class HandPath:
    """From one place to another, each a position in m and a rotation vector (6,), in the operator frame."""

    begin: Array
    end: Array
    begun_ns: int
    takes_ns: int
    circle_m: Array
    hz: float

    @classmethod
    def still(cls) -> "HandPath":
        """A hand at home."""
        return cls(np.zeros(6), np.zeros(6), 0, 1, np.zeros(3), 0.0)

    def then(self, words: dict[str, Any]) -> "HandPath":
        """The next path, as it was told, from where this one is then."""
        begun_ns, takes_ns = words["begun_ns"], round(words["seconds"] * NS_PER_S)
        circle_m = np.array(words.get("circle_m", (0.0, 0.0, 0.0)))
        return HandPath(self.at(begun_ns), np.array(words["to"]), begun_ns, takes_ns, circle_m, words.get("hz", 0.0))

    def at(self, t_ns: int) -> Array:
        """The place (6,) at a time."""
        share = min(max((t_ns - self.begun_ns) / self.takes_ns, 0.0), 1.0)
        smooth = share**3 * (10 - 15 * share + 6 * share**2)
        place = self.begin + smooth * (self.end - self.begin)
        angle = 2 * np.pi * self.hz * max(t_ns - self.begun_ns, 0) / NS_PER_S
        place[:3] += self.circle_m * np.sin(angle * PHASES)
        return place
