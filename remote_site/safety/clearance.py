"""Where the arm may be: the tool in its box, everything far enough from everything else, on all the way to rest."""

import math

import numpy as np

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.clearance_cache import ClearanceCache
from remote_site.safety.collision import CollisionModel, Pairs
from remote_site.safety.stopping import JointStop

POSITION = 1e-9  # m: what rounding may add to a position
TOLERANCE = 5e-4  # m: what moves no further from a posture that is looked at counts as there
NOISE = 1e-6  # m: how exactly a distance is found
RETREAT_LOOKS = 12  # instants of a retreat
HALF_WAY = 0.3  # of the time of a stop: after it about half the way is left
MOST_LOOKS = 100  # parts of one way to rest; a way that needs more is not clear
Kinds = Pairs  # of room: 0 is the tool's in its box, 1 that between the first pair
NO_KINDS: Kinds = np.zeros(0, dtype=np.intp)


class Workspace:
    """The box of the tool centre point in the base frame: lower and upper corner (3,) in m."""

    def __init__(self, lower: Array, upper: Array) -> None:
        self.lower, self.upper = lower, upper
        self._lower, self._upper = lower.tolist(), upper.tolist()

    def depth(self, point_in_base: Array) -> float:
        """How far a point lies inside, m; negative outside, and -inf if it is not finite."""
        x, y, z = point_in_base.tolist()
        if not math.isfinite(x + y + z):
            return -math.inf
        (left, near, bottom), (right, far, top) = self._lower, self._upper
        depth: float = min(x - left, right - x, y - near, far - y, z - bottom, top - z)
        return depth

    def excess(self, point_in_base: Array) -> float:
        """How far a point lies outside, m; 0 inside."""
        return max(0.0, -self.depth(point_in_base))

    def clamp(self, point_in_base: Array) -> Array:
        """The nearest point of the box."""
        clamped: Array = np.minimum(np.maximum(point_in_base, self.lower), self.upper)
        return clamped


class ClearanceCheck:
    """Judges the way to rest of the whole arm, not only its ends.

    Nothing moves further than its joints' levers let it; where there is room for that around the middle of a part of
    the way, nothing else of it has to be looked at. Distances count beyond the margin.
    """

    def __init__(self, model: ArmModel, workspace: Workspace, collision: CollisionModel) -> None:
        self._model = model
        self._workspace = workspace
        self.collision = collision
        self._tool = np.array(model.tcp_levers)
        self._levers = np.vstack([self._tool, collision.levers])
        self._every: Kinds = np.arange(len(self._levers))
        self._slack = ClearanceCache(self._levers)
        self._kept = collision.margin + TOLERANCE

    def in_doubt(self, q: list[float], reach: list[float]) -> Kinds:
        """Which kinds of room may end in postures that no joint is further than `reach` (n,) from `q` (n,)."""
        if self._slack.covers(q, reach):
            return NO_KINDS
        return self._look(np.array(q), np.array(reach))

    def _look(self, q: Array, reach: Array) -> Kinds:
        """The same, when nothing that was noted covers it: depth and distances are looked at, and noted."""
        rooms = np.concatenate([[self._depth(q)], self.collision.rooms(q, reach, self._kept)])
        self._slack.note(q.tolist(), rooms)
        return np.flatnonzero(~(rooms >= self._levers.dot(reach)))

    def clear(self, ends: list[JointStop], kinds: Kinds | None = None) -> bool:
        """Whether the arm stays where it may be until all stops have ended, if only some kinds of room may end.

        Ever shorter parts of the way are looked at, each only for what was in doubt before, until nothing is.
        """
        kinds = self._every if kinds is None else kinds
        duration = max(stop.duration for stop in ends)
        first, last = _at(ends, 0.0), _at(ends, duration)
        if not (self._rooms(last, kinds) >= -POSITION).all():
            return False
        parts = [(0.0, first, duration, last, kinds)]
        for _ in range(MOST_LOOKS):
            if not parts:
                return True
            begin, first, end, last, kinds = parts.pop()
            doubtful = self._doubtful(*_within(ends, first, last, end - begin), kinds)
            if doubtful is None:
                return False
            if len(doubtful):
                half = begin + (HALF_WAY if end == duration else 0.5) * (end - begin)
                between = _at(ends, half)
                parts += [(begin, first, half, between, doubtful), (half, between, end, last, doubtful)]
        return False

    def retreats(self, ends: list[JointStop], q: Array) -> bool:
        """Whether an arm that is where it may not be, at `q` (n,) rad, gets into nothing worse until all stops end."""
        here = self._rooms(q, self._every)
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

    def _doubtful(self, q: Array, reach: Array, kinds: Kinds) -> Kinds | None:
        """Which kinds of room may end in postures within `reach` (n,) of `q`; None if one surely does."""
        ways = self._levers[kinds] @ reach
        rooms = self._rooms(q, kinds)
        enough = rooms >= ways - np.minimum(ways, TOLERANCE) - POSITION
        if (~enough & ((ways <= TOLERANCE) | (rooms < -ways))).any():
            return None
        return kinds[~enough]

    def _rooms(self, q: Array, kinds: Kinds) -> Array:
        """The room of some kinds: 0 is the box, 1 the first pair beyond what it keeps, m."""
        rooms: Array = self.collision.distances(q, kinds[kinds > 0] - 1) - self._kept
        return rooms if len(rooms) == len(kinds) else np.concatenate([[self._depth(q)], rooms])

    def _depth(self, q: Array) -> float:
        return self._workspace.depth(self._model.position(q))

    def _worst(self, ends: list[JointStop]) -> Array:
        """The least room of each kind on the way to rest."""
        duration = max(stop.duration for stop in ends)
        instants = np.linspace(0.0, duration, RETREAT_LOOKS) if duration else (0.0,)
        rooms: Array = np.min([self._rooms(_at(ends, t), self._every) for t in instants], axis=0)
        return rooms


def _within(ends: list[JointStop], first: Array, last: Array, seconds: float) -> tuple[Array, Array]:
    """A middle (n,) and a reach (n,) of all postures on a part of the way, from those at its ends."""
    ways = [
        stop.fastest * seconds if stop.turns_round else abs(b - a)
        for stop, a, b in zip(ends, first.tolist(), last.tolist(), strict=True)
    ]
    return (first + last) / 2, np.array(ways) / 2


def _at(ends: list[JointStop], t: float) -> Array:
    return np.array([stop.at(t)[0] for stop in ends])
