"""Where the arm may be: the tool in its box, everything far enough from everything else, on all the way to rest."""

import math

import numpy as np

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.model import ArmModel
from remote_site.safety.collision import CollisionModel
from remote_site.safety.status import Code, Reason, reason
from remote_site.safety.stopping import JointStop

POSITION = 1e-9  # m: what rounding may add to a position
TOLERANCE = 5e-4  # m: between two instants that are looked at, nothing moves further from both
NOISE = 1e-6  # m: how exactly a distance is found
RETREAT_LOOKS = 12  # instants of a retreat
MOST_LOOKS = 100  # instants of one way to rest; a way that needs more is not clear


class Workspace:
    """The box of the tool centre point in the base frame: lower and upper corner (3,) in m."""

    def __init__(self, lower: Array, upper: Array) -> None:
        self.lower, self.upper = lower, upper
        self._lower, self._upper = lower.tolist(), upper.tolist()

    def depth(self, point_in_base: Array) -> float:
        """How far a point lies inside, m; negative outside, and -inf if it is not finite."""
        point = point_in_base.tolist()
        if not math.isfinite(sum(point)):
            return -math.inf
        depth: float = min(min(x - low, high - x) for low, x, high in zip(self._lower, point, self._upper, strict=True))
        return depth

    def excess(self, point_in_base: Array) -> float:
        """How far a point lies outside, m; 0 inside."""
        return max(0.0, -self.depth(point_in_base))

    def clamp(self, point_in_base: Array) -> Array:
        """The nearest point of the box."""
        clamped: Array = np.minimum(np.maximum(point_in_base, self.lower), self.upper)
        return clamped


class Surroundings:
    """Judges the way to rest of the whole arm, not only its ends.

    Nothing moves further than its joints' levers let it; between two instants at which there is room for half of that,
    nothing has to be looked at. Distances count beyond the margin.
    """

    def __init__(self, model: ArmModel, workspace: Workspace, collision: CollisionModel) -> None:
        self._model = model
        self._workspace = workspace
        self.collision = collision
        self._tool = np.array(model.tcp_levers)
        self._levers = np.vstack([self._tool, collision.levers])
        self._kept = collision.margin + TOLERANCE

    def clear(self, ends: list[JointStop], q: Array) -> bool:
        """Whether the arm stays where it may be from `q` (n,) rad until all stops have ended."""
        travel = np.array([stop.travel for stop in ends])
        depth = self._workspace.depth(self._model.forward(q)[:3, 3])
        if depth >= self._tool @ travel and self.collision.keeps(q, travel, self._kept):
            return True
        return self._clear_between(ends, q)

    def retreats(self, ends: list[JointStop], q: Array) -> bool:
        """Whether an arm that is where it may not be, at `q` (n,) rad, gets into nothing worse until all stops end."""
        here = self._rooms(q)
        if here.min() >= -NOISE:
            return False
        allowed = np.minimum(here, 0.0)
        allowed[1:] -= NOISE
        return bool((self._worst(ends) >= allowed - POSITION).all())

    def why(self, motion: JointMotion, ends: list[JointStop]) -> Reason:
        """What is wrong with a motion's way to rest."""
        worst = self._worst(ends)
        if worst[0] < -POSITION:
            return reason(Code.WORKSPACE, excess_mm=-worst[0] * 1e3)
        rest = np.array([stop.end for stop in ends])
        at = rest if self.collision.distance(rest) < self.collision.distance(motion.q) else motion.q
        distance, (first, second) = self.collision.distance(at), self.collision.nearest(at)
        return reason(
            Code.COLLISION, first=first, second=second, distance_mm=distance * 1e3, limit_mm=self.collision.margin * 1e3
        )

    def _clear_between(self, ends: list[JointStop], q: Array) -> bool:
        """Look at ever shorter parts of the way, until each is known to be clear."""
        duration = max(stop.duration for stop in ends)
        speeds = self._levers @ np.array([stop.fastest for stop in ends])
        here, rest = self._rooms(q), self._rooms(_at(ends, duration))
        if not min(here.min(), rest.min()) >= -POSITION:
            return False
        parts = [(0.0, here, duration, rest)]
        for _ in range(MOST_LOOKS):
            if not parts:
                return True
            begin, room, end, last = parts.pop()
            travel = speeds * (end - begin)
            if travel.max() <= 2 * TOLERANCE or (room + last >= travel).all():
                continue
            middle = (begin + end) / 2
            between = self._rooms(_at(ends, middle))
            if not between.min() >= -POSITION:
                return False
            parts += [(begin, room, middle, between), (middle, between, end, last)]
        return False

    def _rooms(self, q: Array) -> Array:
        """The room in the box, then of every pair beyond what it keeps, m."""
        depth = self._workspace.depth(self._model.forward(q)[:3, 3])
        return np.concatenate([[depth], self.collision.distances(q) - self._kept])

    def _worst(self, ends: list[JointStop]) -> Array:
        """The least room of each kind on the way to rest."""
        duration = max(stop.duration for stop in ends)
        instants = np.linspace(0.0, duration, RETREAT_LOOKS) if duration else (0.0,)
        rooms: Array = np.min([self._rooms(_at(ends, t)) for t in instants], axis=0)
        return rooms


def _at(ends: list[JointStop], t: float) -> Array:
    return np.array([stop.at(t)[0] for stop in ends])
