"""Inverse kinematics along the tool's path, no further at a time than the joints can follow; pure."""

import numpy as np

from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from remote_site.kinematics.inverse import Solution, SphericalWristInverse, Unreachable
from remote_site.kinematics.limits import JointLimits

PACE = 0.75  # of the joints' speed, for solutions: the rest is for what is predicted, and to catch up
CLOSE = 1.05  # of what the joints can: near enough
PASSES = 3  # most corrections of how far that is


class PacedInverse:
    """The closed form for a target that may move faster than the joints.

    A joint that is too slow for its own part of a motion takes the tool off its path, by decimetres near a stretched
    elbow. So a target that asks for too much is approached along the tool's path, which moves and turns in proportion.
    """

    def __init__(self, inverse: SphericalWristInverse, limits: JointLimits) -> None:
        self._inverse = inverse
        self._fastest = PACE * limits.velocity
        self._pose, self._q = np.eye(4), np.zeros(len(limits.names))

    def reset(self, base_T_tool: Array, q: Array) -> None:
        """Begin at the tool's pose (4 x 4), where the joints are at `q` (6,) rad."""
        self._pose, self._q = base_T_tool, q

    def towards(self, base_T_target: Array, elapsed_s: float, speed: float) -> Solution | Unreachable:
        """The solution on the way to a target (4 x 4), `elapsed_s` after the last one, at a fraction of full speed.

        Unreachable is told of the target itself; the last solution then remains.
        """
        asked = self._inverse.nearest(base_T_target, self._q, elapsed_s, speed)
        if isinstance(asked, Unreachable):
            return asked
        pose, found = base_T_target, asked
        needed = self._effort(asked, elapsed_s, speed)
        if needed > 1.0:
            pose, found = self._on_the_way(base_T_target, needed, elapsed_s, speed) or (pose, found)
        self._pose, self._q = pose, found.q
        return found

    def _on_the_way(
        self, base_T_target: Array, needed: float, elapsed_s: float, speed: float
    ) -> tuple[Array, Solution] | None:
        """A pose for which the joints are quick enough, if the whole way needs `needed` times what they can."""
        way = base_T_target[:3, 3] - self._pose[:3, 3]
        turn = vector_from_rotation(self._pose[:3, :3].T @ base_T_target[:3, :3])
        part, best = 1.0, None
        for _ in range(PASSES):
            part /= needed
            rotation = self._pose[:3, :3] @ rotation_from_vector(part * turn)
            pose = transform(rotation, self._pose[:3, 3] + part * way)
            found = self._inverse.nearest(pose, self._q, elapsed_s, speed)
            if isinstance(found, Unreachable):
                break
            best, needed = (pose, found), self._effort(found, elapsed_s, speed)
            if needed <= CLOSE:
                break
        return best

    def _effort(self, solution: Solution, elapsed_s: float, speed: float) -> float:
        """The greatest share of its pace that a joint needs to get there in time."""
        return float(np.max(np.abs(solution.q - self._q) / self._fastest)) / (speed * elapsed_s)
