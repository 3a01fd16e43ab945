"""Distances of the arm to itself and to the fixtures of its cell, and bounds of them between measurements."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from common.geometry import Array
from remote_site.kinematics.config import CapsuleConfig
from remote_site.kinematics.model import ArmModel
from remote_site.safety.collision_geometry import pair_levers, read_shapes, shape_name
from remote_site.safety.config import CollisionConfig

MIN_NORMAL = 1e-9
SOON = 0.03  # m: pairs that this much more travel would put in doubt are measured along with those that are
NOWHERE = 1e9  # rad: no posture that was ever measured
Pairs = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class ClosePair:
    """Two bodies close to each other: `gradient` (n,) is the change of the distance in m per rad of a joint."""

    names: tuple[str, str]
    distance: float
    gradient: Array


class ClearanceCache:
    """The way that the arm may still move before any known clearance is in doubt.

    No joint uses up a clearance in m faster than its levers (m x n) in m per rad (or m) allow. Every joint's motion
    costs the greatest fraction that it may take of any clearance, so that their sum is never too low: one short sum in
    most ticks, instead of all clearances.
    """

    def __init__(self, levers: Array) -> None:
        self._levers = levers
        self._where = self._costs = [math.nan] * levers.shape[1]

    def note(self, q: list[float], clearances: Array) -> None:
        """The clearances (m,) at joint positions (n,) in rad; where one is not positive, nothing is covered."""
        self._where = q
        if clearances.min(initial=math.inf) > 0.0:
            self._costs = (self._levers / clearances[:, None]).max(axis=0, initial=0.0).tolist()
        else:
            self._costs = [math.nan] * len(q)

    def covers(self, q: list[float], travel: list[float]) -> bool:
        """Return whether every clearance outlasts the motion to `q` (n,) and `travel` (n,) from there; never if NaN."""
        used = 0.0
        for cost, here, there, more in zip(self._costs, q, self._where, travel, strict=True):
            used += cost * (abs(here - there) + more)
        return used <= 1.0


class CollisionModel:
    """The shortest distances between the links of an arm, and between them and the fixtures of its cell.

    One instance serves one thread. For joints that are not finite every distance is -inf.
    """

    def __init__(self, model: ArmModel, shapes: pin.GeometryModel, margin_m: float) -> None:
        self._pin_model = model.pin_model
        self._data = model.pin_model.createData()
        self._shapes = shapes
        self.margin = margin_m
        self._distances = shapes.createData()
        levers = pair_levers(model, shapes)
        self.levers: Array = np.array(levers).reshape(len(levers), -1)
        # of each pair: the joints where it was measured last, and what it was there
        self._at = np.full((len(levers), len(model.joint_names)), NOWHERE)
        self._known = np.full(len(levers), -math.inf)
        self._still = np.zeros(len(model.joint_names))
        self._caches: dict[float, ClearanceCache] = {}

    @classmethod
    def from_urdf(
        cls, path: Path, model: ArmModel, capsules: tuple[CapsuleConfig, ...], config: CollisionConfig
    ) -> Self:
        """The model of a URDF's collision elements, capsules and fixtures; raises as `read_shapes` does."""
        return cls(model, read_shapes(path, model, capsules, config), config.margin_m)

    def distance(self, q: Array) -> float:
        """The least distance in m at joint positions (n,) in rad; negative where bodies overlap, inf without any."""
        if not math.isfinite(sum(q.tolist())):
            return -math.inf
        bounds, least = self._bounds(q), math.inf
        pin.updateGeometryPlacements(self._pin_model, self._data, self._shapes, self._distances, q)
        for k in np.argsort(bounds).tolist():
            if bounds[k] >= least:
                break
            least = min(least, self._exact(k))
        return least

    def clearances(self, q: Array, travel: Array, distance: float) -> Array:
        """A lower bound of how much more than a distance in m every pair (m,) keeps at `q`; -inf if `q` is not finite.

        An earlier measurement is enough as long as it leaves no doubt about a travel (n,) from `q`: a pair's distance
        changes by no more than its joints' levers allow. Only the pairs in doubt are measured, and those that soon
        will be.
        """
        if not math.isfinite(sum(q.tolist())):
            return np.full(len(self._known), -math.inf)
        clearances = self._bounds(q) - distance
        pairs = np.flatnonzero(~(clearances >= self.levers.dot(travel) + SOON))  # NaN and -inf are never enough
        if len(pairs):
            found = self._known[pairs] = self._measure(q, pairs)
            self._at[pairs] = q
            clearances[pairs] = found - distance
        return clearances

    def distances(self, q: Array, pairs: Pairs | None = None) -> Array:
        """The distances (m,) in m of some pairs, or of all; -inf where one is unknown."""
        every = np.arange(len(self._known)) if pairs is None else pairs
        if not math.isfinite(sum(q.tolist())):
            return np.full(max(len(every), 1), -math.inf)
        return self._measure(q, every)

    def nearest(self, q: Array) -> tuple[str, str]:
        """The names of the two bodies that are nearest to each other."""
        return self.names(int(np.argmin(self.distances(q))))

    def names(self, k: int) -> tuple[str, str]:
        """The names of the two bodies of a pair, by its place among `distances`."""
        pair, objects = self._shapes.collisionPairs[k], self._shapes.geometryObjects
        return shape_name(self._pin_model, objects[pair.first]), shape_name(self._pin_model, objects[pair.second])

    def pairs_within(self, q: Array, distance: float) -> list[ClosePair]:
        """The pairs nearer than a distance in m at finite `q`, with the gradients of their distances."""
        cache = self._caches.setdefault(distance, ClearanceCache(self.levers))
        if cache.covers(q.tolist(), self._still.tolist()):
            return []
        clearances = self.clearances(q, self._still, distance)
        cache.note(q.tolist(), clearances)
        close = np.flatnonzero(~(clearances >= 0.0)).tolist()
        if not close:
            return []
        jacobian: Array = pin.computeJointJacobians(self._pin_model, self._data, q)
        return [ClosePair(self.names(k), float(self._known[k]), self._gradient(k, jacobian)) for k in close]

    def _bounds(self, q: Array) -> Array:
        """A lower bound of every pair's distance (m,) in m at `q`, by the last measurements and the levers."""
        bounds: Array = self._known - np.vecdot(self.levers, np.abs(q - self._at))
        return bounds

    def _measure(self, q: Array, pairs: Pairs) -> Array:
        """The distances of pairs at finite `q`, with their nearest points."""
        pin.updateGeometryPlacements(self._pin_model, self._data, self._shapes, self._distances, q)
        return np.array([self._exact(k) for k in pairs.tolist()])

    def _exact(self, k: int) -> float:
        """A pair's distance where its shapes are now; -inf if it is unknown."""
        found: float = pin.computeDistance(self._shapes, self._distances, k).min_distance
        return found if math.isfinite(found) else -math.inf

    def _gradient(self, k: int, jacobian: Array) -> Array:
        """The change of a pair's distance with each joint: along the line between its nearest points."""
        result, pair = self._distances.distanceResults[k], self._shapes.collisionPairs[k]
        normal: list[float] = result.normal.tolist()
        length = math.hypot(*normal)
        gradient = np.zeros(jacobian.shape[1])
        if length < MIN_NORMAL:
            return gradient
        ends = ((-1.0, pair.first, result.getNearestPoint1()), (1.0, pair.second, result.getNearestPoint2()))
        for side, shape, point in ends:
            joints = self._shapes.geometryObjects[shape].parentJoint
            gradient[:joints] += side / length * (_wrench(point.tolist(), normal) @ jacobian[:, :joints])
        return gradient


def _wrench(point: list[float], force: list[float]) -> Array:
    """A force at a point as force and moment about the origin (6,)."""
    (x, y, z), (u, v, w) = point, force
    return np.array([u, v, w, y * w - z * v, z * u - x * w, x * v - y * u])
