"""Inverse kinematics along the way of the tool's target, from each target to the next; pure."""

import math

import numpy as np

from common.geometry import Array, pose_between
from remote_site.kinematics.inverse import Solution, SphericalWristInverse, Unreachable

SPACING_RAD = 0.03  # of the solutions on the way: so close, joints that move straight keep the tool on it
MOST = 12  # solutions from one target to the next


class PathInverse:
    """The closed form at each target of the tool, and on the straight way there, turned in proportion.

    `q` (6,) in rad is the newest solution.
    """

    def __init__(self, inverse: SphericalWristInverse) -> None:
        self._inverse = inverse
        self._pose, self.q = np.eye(4), np.zeros(6)

    def reset(self, base_T_tool: Array, q: Array) -> None:
        """Begin at the tool's pose (4 x 4), where the joints are at `q` (6,) rad."""
        self._pose, self.q = base_T_tool, q

    def to(self, base_T_target: Array, elapsed_s: float, speed: float) -> Solution | Unreachable:
        """The solution for a target (4 x 4), `elapsed_s` after the last one, at a fraction of full speed."""
        found = self._inverse.nearest(base_T_target, self.q, elapsed_s, speed)
        if isinstance(found, Solution):
            self._pose, self.q = base_T_target, found.q
        return found

    def along(self, base_T_target: Array, elapsed_s: float, speed: float) -> list[Solution] | Unreachable:
        """The same as `to`, after the solutions on the way to it; those out of reach are left out.

        Each is the nearest to the one before, so that joint 4, which only goes as far as the time allows where the
        wrist is straight, does not swing between what is solved at once and what is solved step by step.
        """
        pose, q = self._pose, self.q
        at_once = self.to(base_T_target, elapsed_s, speed)
        if isinstance(at_once, Unreachable):
            return at_once
        steps = min(math.ceil(float(np.abs(at_once.q - q).max()) / SPACING_RAD), MOST)
        found: list[Solution] = []
        for k in range(steps if steps > 1 else 0):
            on_the_way = pose_between(pose, base_T_target, (k + 1) / steps)
            solution = self._inverse.nearest(on_the_way, found[-1].q if found else q, elapsed_s / steps, speed)
            if isinstance(solution, Solution):
                found.append(solution)
            elif k + 1 == steps:
                found.append(at_once)
        found = found or [at_once]
        self.q = found[-1].q
        return found
