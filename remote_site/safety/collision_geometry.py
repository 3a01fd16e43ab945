"""The shapes of an arm and its cell whose distances are measured: from its URDF, capsules and fixtures, in pairs."""

import itertools
import math
from pathlib import Path
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin

from common.errors import ConfigError, ModelError
from common.geometry import Array
from remote_site.kinematics.config import CapsuleConfig
from remote_site.kinematics.meshes import check_meshes, place_meshes, words_of
from remote_site.kinematics.model import IMPORT, ArmModel
from remote_site.safety.config import CollisionConfig, FixtureConfig

NEIGHBOURS = 1  # joints apart: links that touch by construction


def read_shapes(
    path: Path, model: ArmModel, capsules: tuple[CapsuleConfig, ...], config: CollisionConfig
) -> pin.GeometryModel:
    """The collision elements of a URDF, the configured capsules, and the fixtures, with all pairs to measure.

    A cylinder of the URDF counts as the capsule around it. ConfigError names a link that the arm does not have,
    ModelError a mesh that is missing or cannot be read.
    """
    shapes = _read_collisions(path, model)
    for shape in shapes.geometryObjects:
        shape.geometry = _smooth(shape.geometry)
    for k, capsule in enumerate(capsules):
        shapes.addGeometryObject(_capsule(model, capsule, k))
    for fixture in config.fixtures:
        shapes.addGeometryObject(_box(fixture))
    _add_pairs(model.pin_model, shapes, config)
    return shapes


def _read_collisions(path: Path, model: ArmModel) -> pin.GeometryModel:
    """The collision elements of a URDF as they are; ModelError says which mesh stands against it."""
    try:
        robot = ElementTree.parse(path).getroot()  # noqa: S314  # the robot model is the site's own
        meshes = robot.findall("link/collision/geometry/mesh")
        place_meshes(path.parent, meshes)
        check_meshes(path, meshes)
        text = ElementTree.tostring(robot, encoding="unicode")
        return pin.buildGeomFromUrdfString(model.pin_model, text, pin.GeometryType.COLLISION)
    except (OSError, ElementTree.ParseError, ValueError, RuntimeError) as error:
        cure = f"give meshes as STL, OBJ or Collada, or let Farhand find them: {IMPORT.format(urdf=path)}"
        raise ModelError(f"cannot read the collision elements of {path}: {words_of(error)}; {cure}") from error


def shape_name(model: pin.Model, shape: pin.GeometryObject) -> str:
    """The fixture's own name, or the link's."""
    frame = shape.parentFrame
    return str(model.frames[frame].name) if 0 < frame < model.nframes else str(shape.name)


def links_without_shape(model: pin.Model, shapes: pin.GeometryModel) -> list[str]:
    """The links of an arm that no shape moves with, by name: nothing measures how near they come."""
    covered = {int(shape.parentJoint) for shape in shapes.geometryObjects}
    links = [frame for frame in model.frames if frame.type == pin.FrameType.BODY]
    bare = [joint for joint in range(1, model.njoints) if joint not in covered]
    return [next(str(link.name) for link in links if link.parentJoint == joint) for joint in bare]


def pair_levers(model: ArmModel, shapes: pin.GeometryModel) -> list[list[float]]:
    """The most that the two shapes of each pair can move relative to each other per rad (or m) of each joint, m."""
    joints = [int(shape.parentJoint) for shape in shapes.geometryObjects]
    of_shapes: dict[int, list[float]] = {}
    of_pairs = []
    for pair in shapes.collisionPairs:
        inner, outer = sorted((int(pair.first), int(pair.second)), key=joints.__getitem__)
        if outer not in of_shapes:
            of_shapes[outer] = _levers(model, shapes.geometryObjects[outer])
        of_pairs.append([0.0] * joints[inner] + of_shapes[outer][joints[inner] :])
    return of_pairs


def _levers(model: ArmModel, shape: pin.GeometryObject) -> list[float]:
    """The most that a shape can move per rad (or m) of each joint, m."""
    shape.geometry.computeLocalAABB()
    box = shape.geometry.aabb_local
    corners = np.array(list(itertools.product(*zip(box.min_.tolist(), box.max_.tolist(), strict=True))))
    moved: Array = corners @ shape.placement.rotation.T + shape.placement.translation
    return model.levers(shape.parentJoint, moved)


def _add_pairs(model: pin.Model, shapes: pin.GeometryModel, config: CollisionConfig) -> None:
    """Pair every link with every other that is not its neighbour, and all that move with all fixtures."""
    objects = list(shapes.geometryObjects)
    names = [shape_name(model, shape) for shape in objects]
    ignored = {frozenset(pair) for pair in config.ignored_pairs}
    unknown = sorted({name for pair in ignored for name in pair} - set(names))
    if unknown:
        known = ", ".join(sorted(set(names)))
        raise ConfigError(f"safety.collision.ignored_pairs: no {', '.join(unknown)}; there are {known}")
    fixtures = range(len(objects) - len(config.fixtures), len(objects))
    for i, j in itertools.combinations(range(len(objects)), 2):
        apart = abs(objects[i].parentJoint - objects[j].parentJoint)
        near = apart == 0 or (apart <= NEIGHBOURS and j not in fixtures)
        if not near and frozenset((names[i], names[j])) not in ignored:
            shapes.addCollisionPair(pin.CollisionPair(i, j))


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
