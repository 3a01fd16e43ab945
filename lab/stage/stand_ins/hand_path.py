"""The path of a scripted hand: a smooth glide to a pose, and a circle around it; pure."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array

PHASES = np.array([1.0, 0.5, 1.5])


@dataclass(frozen=True)
class ScriptedPath:
    """From one pose to another, each a position in m and a rotation vector (6,), in the operator frame."""

    begin: Array
    end: Array
    begun_ns: int
    takes_ns: int
    circle_m: Array
    hz: float

    @classmethod
    def still(cls) -> "ScriptedPath":
        """A hand at home."""
        return cls(np.zeros(6), np.zeros(6), 0, 1, np.zeros(3), 0.0)

    def then(self, fields: dict[str, Any]) -> "ScriptedPath":
        """The next path, as commanded, from where this one is then."""
        begun_ns, takes_ns = fields["begun_ns"], round(fields["seconds"] * NS_PER_S)
        circle_m = np.array(fields.get("circle_m", (0.0, 0.0, 0.0)))
        return ScriptedPath(
            self.at(begun_ns), np.array(fields["to"]), begun_ns, takes_ns, circle_m, fields.get("hz", 0.0)
        )

    def at(self, t_ns: int) -> Array:
        """The pose (6,) at a time."""
        fraction = min(max((t_ns - self.begun_ns) / self.takes_ns, 0.0), 1.0)
        smooth = fraction**3 * (10 - 15 * fraction + 6 * fraction**2)
        pose = self.begin + smooth * (self.end - self.begin)
        angle = 2 * np.pi * self.hz * max(t_ns - self.begun_ns, 0) / NS_PER_S
        pose[:3] += self.circle_m * np.sin(angle * PHASES)
        return pose
