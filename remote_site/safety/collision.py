"""Distances of the arm to itself and to what stands around it, from capsules and boxes; pure."""

import itertools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from common.errors import ConfigError, ModelError
from common.geometry import Array
from remote_site.kinematics.config import CapsuleConfig
from remote_site.kinematics.model import ArmModel
from remote_site.safety.clearance_cache import ClearanceCache
from remote_site.safety.config import CollisionConfig, FixtureConfig

MIN_NORMAL = 1e-9
SOON = 0.03  # m: the pairs that much nearer approach would put in doubt are measured along with those that are
NOWHERE = 1e9  # rad: no posture that was ever measured
NEIGHBOURS = 1  # joints apart: links that touch by construction
Pairs = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Near:
    """Two bodies that are near each other: `gradient` (n,) says how their distance in m grows per rad of each joint."""

    names: tuple[str, str]
    distance: float
    gradient: Array


class CollisionModel:
    """The shortest distances between the links of an arm, and between them and the fixtures of its cell.

    One instance serves one thread. Joints that are not finite are never far from anything: their distance is -inf.
    """

    def __init__(self, model: ArmModel, shapes: pin.GeometryModel, config: CollisionConfig) -> None:
        self._pin_model = model.pin_model
        self._data = model.pin_model.createData()
        self._shapes = shapes
        self.margin = config.margin_m
        for fixture in config.fixtures:
            shapes.addGeometryObject(_box(fixture))
        self._add_pairs(config)
        self._distances = shapes.createData()
        pairs = [(pair.first, pair.second) for pair in shapes.collisionPairs]
        self.levers: Array = np.array([_levers(model, shapes, *pair) for pair in pairs]).reshape(len(pairs), -1)
        # of each pair: the joints where it was measured last, and what it was there
        self._at = np.full((len(pairs), len(model.joint_names)), NOWHERE)
        self._known = np.full(len(pairs), -math.inf)
        self._still = np.zeros(len(model.joint_names))
        self._slack: dict[float, ClearanceCache] = {}

    @classmethod
    def from_urdf(
        cls, path: Path, model: ArmModel, capsules: tuple[CapsuleConfig, ...], config: CollisionConfig
    ) -> Self:
        """The collision elements of a URDF, the configured capsules, and the fixtures.

        A cylinder of the URDF counts as the capsule around it. ConfigError names a link that the arm does not have.
        """
        try:
            shapes = pin.buildGeomFromUrdf(model.pin_model, str(path), pin.GeometryType.COLLISION)
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"cannot read the collision elements of {path}: {error}") from error
        for shape in shapes.geometryObjects:
            shape.geometry = _smooth(shape.geometry)
        for k, capsule in enumerate(capsules):
            shapes.addGeometryObject(_capsule(model, capsule, k))
        return cls(model, shapes, config)

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

    def rooms(self, q: Array, travel: Array, distance: float) -> Array:
        """How much more than a distance in m every pair (m,) keeps at `q` at least, m; -inf where `q` is not finite.

        What was measured before is enough as long as it leaves no doubt about a way of `travel` (n,) from `q`: a pair's
        distance changes by no more than its joints' levers allow. Only the pairs in doubt are measured, and those that
        soon will be.
        """
        if not math.isfinite(sum(q.tolist())):
            return np.full(len(self._known), -math.inf)
        rooms = self._bounds(q) - distance
        pairs = np.flatnonzero(~(rooms >= self.levers.dot(travel) + SOON))  # NaN and -inf are never enough
        if len(pairs):
            rooms[pairs] = self._look(q, pairs) - distance
        return rooms

    def distances(self, q: Array, pairs: Pairs | None = None) -> Array:
        """The distances (m,) in m of some pairs, or of all; -inf where it cannot be told."""
        every = np.arange(len(self._known)) if pairs is None else pairs
        if not math.isfinite(sum(q.tolist())):
            return np.full(max(len(every), 1), -math.inf)
        return self._measure(q, every)

    def _bounds(self, q: Array) -> Array:
        """What every pair's distance (m,) in m is at least at `q`, by what was measured and the levers."""
        bounds: Array = self._known - np.vecdot(self.levers, np.abs(q - self._at))
        return bounds

    def _look(self, q: Array, pairs: Pairs) -> Array:
        """Measure pairs at finite `q`, and remember."""
        found = self._known[pairs] = self._measure(q, pairs)
        self._at[pairs] = q
        return found

    def _measure(self, q: Array, pairs: Pairs) -> Array:
        """The distances of pairs at finite `q`, with their nearest points."""
        pin.updateGeometryPlacements(self._pin_model, self._data, self._shapes, self._distances, q)
        return np.array([self._exact(k) for k in pairs.tolist()])

    def _exact(self, k: int) -> float:
        """A pair's distance where its shapes were placed; -inf if it cannot be told."""
        found: float = pin.computeDistance(self._shapes, self._distances, k).min_distance
        return found if math.isfinite(found) else -math.inf

    def nearest(self, q: Array) -> tuple[str, str]:
        """The names of the two bodies that are nearest to each other."""
        return self._names(int(np.argmin(self.distances(q))))

    def nearer_than(self, q: Array, distance: float) -> list[Near]:
        """The pairs nearer than a distance in m at finite `q`, with the gradients of their distances."""
        slack = self._slack.setdefault(distance, ClearanceCache(self.levers))
        if slack.covers(q.tolist(), self._still.tolist()):
            return []
        rooms = self.rooms(q, self._still, distance)
        slack.note(q.tolist(), rooms)
        close = np.flatnonzero(~(rooms >= 0.0)).tolist()
        if not close:
            return []
        jacobian: Array = pin.computeJointJacobians(self._pin_model, self._data, q)
        return [Near(self._names(k), float(self._known[k]), self._gradient(k, jacobian)) for k in close]

    def _gradient(self, k: int, jacobian: Array) -> Array:
        """How a pair's distance grows with each joint: along the line between its nearest points."""
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

    def _names(self, k: int) -> tuple[str, str]:
        pair = self._shapes.collisionPairs[k]
        first, second = (self._name(self._shapes.geometryObjects[i]) for i in (pair.first, pair.second))
        return first, second

    def _name(self, shape: pin.GeometryObject) -> str:
        """The fixture's own name, or the link's."""
        frame = shape.parentFrame
        return str(self._pin_model.frames[frame].name) if 0 < frame < self._pin_model.nframes else str(shape.name)

    def _add_pairs(self, config: CollisionConfig) -> None:
        """Pair every link with every other that is not its neighbour, and all that move with all fixtures."""
        shapes = list(self._shapes.geometryObjects)
        names = [self._name(shape) for shape in shapes]
        ignored = {frozenset(pair) for pair in config.ignored_pairs}
        unknown = sorted({name for pair in ignored for name in pair} - set(names))
        if unknown:
            known = ", ".join(sorted(set(names)))
            raise ConfigError(f"safety.collision.ignored_pairs: no {', '.join(unknown)}; there are {known}")
        fixtures = range(len(shapes) - len(config.fixtures), len(shapes))
        for i, first in enumerate(shapes):
            for j in range(i + 1, len(shapes)):
                apart = abs(first.parentJoint - shapes[j].parentJoint)
                near = apart == 0 or (apart <= NEIGHBOURS and j not in fixtures)
                if not near and frozenset((names[i], names[j])) not in ignored:
                    self._shapes.addCollisionPair(pin.CollisionPair(i, j))


def _wrench(point: list[float], force: list[float]) -> Array:
    """A force at a point as force and moment about the origin (6,)."""
    (x, y, z), (u, v, w) = point, force
    return np.array([u, v, w, y * w - z * v, z * u - x * w, x * v - y * u])


def _smooth(geometry: coal.CollisionGeometry) -> coal.CollisionGeometry:
    """The shape that is measured instead: a capsule around a cylinder, the convex hull of a mesh."""
    if isinstance(geometry, coal.Cylinder):
        return coal.Capsule(geometry.radius, 2 * geometry.halfLength)
    if isinstance(geometry, coal.BVHModelBase):
        geometry.buildConvexHull(True, "Qt")
        return geometry.convex
    return geometry


def _box(fixture: FixtureConfig) -> pin.GeometryObject:
    low, high = np.array(fixture.min_m), np.array(fixture.max_m)
    placement = pin.SE3(np.eye(3), (low + high) / 2)
    return pin.GeometryObject(fixture.name, 0, 0, placement, coal.Box(*(high - low)))


def _capsule(arm: ArmModel, capsule: CapsuleConfig, number: int) -> pin.GeometryObject:
    model, link = arm.pin_model, capsule.link or arm.tool_frame
    if not model.existFrame(link):
        known = ", ".join(frame.name for frame in model.frames)
        raise ConfigError(f"robot.capsules: there is no link {link!r}; the frames are {known}")
    frame_id = model.getFrameId(link)
    frame = model.frames[frame_id]
    start, end = np.array(capsule.start_m), np.array(capsule.end_m)
    along = end - start
    length = math.sqrt(float(along @ along))
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), along / length if length else np.eye(3)[2])
    placement = frame.placement * pin.SE3(turn.matrix(), (start + end) / 2)
    shape = coal.Capsule(capsule.radius_m, length)
    return pin.GeometryObject(f"capsule_{number}", frame.parentJoint, frame_id, placement, shape)


def _levers(model: ArmModel, shapes: pin.GeometryModel, first: int, second: int) -> list[float]:
    """How far two shapes can move against each other at most per rad (or m) of each joint, m: all lengths beyond it."""
    one, other = shapes.geometryObjects[first], shapes.geometryObjects[second]
    inner, outer = sorted((one, other), key=lambda shape: int(shape.parentJoint))
    outer.geometry.computeLocalAABB()
    box = outer.geometry.aabb_local
    corners = np.array(list(itertools.product(*zip(box.min_.tolist(), box.max_.tolist(), strict=True))))
    placed: Array = corners @ outer.placement.rotation.T + outer.placement.translation
    return model.levers(inner.parentJoint, outer.parentJoint, placed)
