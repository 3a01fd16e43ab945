"""Clearance of the arm on all its path to rest: the tool in its box, every pair of bodies apart."""

import math

import numpy as np

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.collision import ClearanceCache, CollisionModel, Pairs
from remote_site.safety.stopping import JointStop

POSITION = 1e-9  # m: what rounding may add to a position
TOLERANCE = 5e-4  # m: a body that moves no further from a checked posture counts as checked
NOISE = 1e-6  # m: accuracy of a distance
RETREAT_CHECKS = 12  # instants of a retreat
HALF_TRAVEL = 0.3  # of the duration of a stop: about half the distance is left
MOST_PARTS = 100  # of one path to rest; a path that needs more is not clear
Indices = Pairs  # of clearances: 0 is the tool's depth in its box, 1 the clearance of the first pair
NONE: Indices = np.zeros(0, dtype=np.intp)


class Workspace:
    """The box of the tool centre point in the base frame: lower and upper corner (3,) in m."""

    def __init__(self, lower: Array, upper: Array) -> None:
        self.lower, self.upper = lower, upper
        self._lower, self._upper = lower.tolist(), upper.tolist()

    def depth(self, point_in_base: Array) -> float:
        """Compute how far a point lies inside, m; negative outside, and -inf if it is not finite."""
        x, y, z = point_in_base.tolist()
        if not math.isfinite(x + y + z):
            return -math.inf
        (left, near, bottom), (right, far, top) = self._lower, self._upper
        depth: float = min(x - left, right - x, y - near, far - y, z - bottom, top - z)
        return depth

    def excess(self, point_in_base: Array) -> float:
        """Compute how far a point lies outside, m; 0 inside."""
        return max(0.0, -self.depth(point_in_base))

    def clamp(self, point_in_base: Array) -> Array:
        """The nearest point of the box."""
        clamped: Array = np.minimum(np.maximum(point_in_base, self.lower), self.upper)
        return clamped


class ClearanceCheck:
    """Judges the whole arm's path to rest, not only its ends.

    Nothing moves further than its joints' levers allow; where the clearances in the middle of a part of the path exceed
    that, the rest of the part needs no check. Clearances count beyond the margin.
    """

    def __init__(self, model: ArmModel, workspace: Workspace, collision: CollisionModel) -> None:
        self._model = model
        self._workspace = workspace
        self.collision = collision
        self._levers = np.vstack([np.array(model.tcp_levers), collision.levers])
        self._every: Indices = np.arange(len(self._levers))
        self._cache = ClearanceCache(self._levers)
        self._kept = collision.margin + TOLERANCE

    def in_doubt(self, q: list[float], reach: list[float]) -> Indices:
        """Find which clearances may end in postures of which no joint is further than `reach` (n,) from `q` (n,)."""
        if self._cache.covers(q, reach):
            return NONE
        return self._look(np.array(q), np.array(reach))

    def _look(self, q: Array, reach: Array) -> Indices:
        """The same where the cache does not cover it: depth and distances are measured, and noted."""
        clearances = np.concatenate([[self._depth(q)], self.collision.clearances(q, reach, self._kept)])
        self._cache.note(q.tolist(), clearances)
        return np.flatnonzero(~(clearances >= self._levers.dot(reach)))

    def clear(self, ends: list[JointStop], doubtful: Indices | None = None) -> bool:
        """Return whether the arm stays clear until all stops have ended, if only some clearances are in doubt.

        Ever shorter parts of the path are checked, each only for what was in doubt before, until nothing is.
        """
        doubtful = self._every if doubtful is None else doubtful
        duration = max(stop.duration for stop in ends)
        first, last = _at(ends, 0.0), _at(ends, duration)
        if not (self._clearances(last, doubtful) >= -POSITION).all():
            return False
        parts = [(0.0, first, duration, last, doubtful)]
        for _ in range(MOST_PARTS):
            if not parts:
                return True
            begin, first, end, last, doubtful = parts.pop()
            left = self._doubtful(*_within(ends, first, last, end - begin), doubtful)
            if left is None:
                return False
            if len(left):
                half = begin + (HALF_TRAVEL if end == duration else 0.5) * (end - begin)
                between = _at(ends, half)
                parts += [(begin, first, half, between, left), (half, between, end, last, left)]
        return False

    def retreats(self, ends: list[JointStop], q: Array) -> bool:
        """Return whether an arm at `q` (n,) rad that is not clear makes no clearance worse until all stops end."""
        here = self._clearances(q, self._every)
        if here.min() >= -NOISE:
            return False
        allowed = np.minimum(here, 0.0)
        allowed[1:] -= NOISE
        return bool((self._worst(ends) >= allowed - POSITION).all())

    def why(self, motion: JointMotion, ends: list[JointStop]) -> Reason:
        """Say what is wrong with a motion's path to rest."""
        worst = self._worst(ends)
        if worst[0] < -POSITION:
            return reason(Code.WORKSPACE, excess_mm=-worst[0] * 1e3)
        rest = np.array([stop.end for stop in ends])
        at = rest if self.collision.distance(rest) < self.collision.distance(motion.q) else motion.q
        distance, (first, second) = self.collision.distance(at), self.collision.nearest(at)
        return reason(
            Code.COLLISION, first=first, second=second, distance_mm=distance * 1e3, limit_mm=self.collision.margin * 1e3
        )

    def _doubtful(self, q: Array, reach: Array, indices: Indices) -> Indices | None:
        """Find which of some clearances may end in postures within `reach` (n,) of `q`; None if one certainly does."""
        travel = self._levers[indices] @ reach
        clearances = self._clearances(q, indices)
        enough = clearances >= travel - np.minimum(travel, TOLERANCE) - POSITION
        if (~enough & ((travel <= TOLERANCE) | (clearances < -travel))).any():
            return None
        return indices[~enough]

    def _clearances(self, q: Array, indices: Indices) -> Array:
        """Some clearances in m; 0 is the tool's depth in the box, 1 the first pair's beyond what it keeps."""
        pairs: Array = self.collision.distances(q, indices[indices > 0] - 1) - self._kept
        return pairs if len(pairs) == len(indices) else np.concatenate([[self._depth(q)], pairs])

    def _depth(self, q: Array) -> float:
        return self._workspace.depth(self._model.position(q))

    def _worst(self, ends: list[JointStop]) -> Array:
        """The least of each clearance on the path to rest."""
        duration = max(stop.duration for stop in ends)
        instants = np.linspace(0.0, duration, RETREAT_CHECKS) if duration else (0.0,)
        least: Array = np.min([self._clearances(_at(ends, t), self._every) for t in instants], axis=0)
        return least


def _within(ends: list[JointStop], first: Array, last: Array, seconds: float) -> tuple[Array, Array]:
    """A middle (n,) and a reach (n,) of all postures on a part of the path, from those at its ends."""
    travel = [
        stop.fastest * seconds if stop.reverses else abs(b - a)
        for stop, a, b in zip(ends, first.tolist(), last.tolist(), strict=True)
    ]
    return (first + last) / 2, np.array(travel) / 2


def _at(ends: list[JointStop], t: float) -> Array:
    return np.array([stop.at(t)[0] for stop in ends])
