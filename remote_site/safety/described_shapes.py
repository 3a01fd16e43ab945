"""The shapes that are guarded, as another site needs them to draw the arm in its cell."""

import coal
import numpy as np
import pinocchio as pin

from common.geometry import Array
from common.messages.shapes import MOST_BOXES, MOST_CAPSULES, BoxDescription, CapsuleDescription
from remote_site.kinematics.model import ArmModel
from remote_site.safety.config import FixtureConfig

THINNEST_M = 0.001


def describe_capsules(model: ArmModel, shapes: pin.GeometryModel) -> tuple[CapsuleDescription, ...]:
    """The shapes that move with the arm or stand on its base as capsules; of too many, the largest.

    A sphere is a capsule without length; any other body is described by one along the longest side of its bounding
    box, with the mean of the others as its thickness.
    """
    arm = [shape for shape in shapes.geometryObjects if 0 < shape.parentFrame < model.pin_model.nframes]
    capsules = [_capsule(model, shape) for shape in arm]
    return tuple(sorted(capsules, key=_length, reverse=True)[:MOST_CAPSULES])


def describe_fixtures(fixtures: tuple[FixtureConfig, ...]) -> tuple[BoxDescription, ...]:
    """The boxes of the cell; of too many, the largest."""
    boxes = [BoxDescription(fixture.name, fixture.min_m, fixture.max_m) for fixture in fixtures]
    return tuple(sorted(boxes, key=_volume, reverse=True)[:MOST_BOXES])


def _capsule(model: ArmModel, shape: pin.GeometryObject) -> CapsuleDescription:
    """In the frame of the joint that moves it; in the tool's where the tool's frame carries it."""
    arm = model.pin_model
    centre, axis, half, radius = _axis(shape.geometry)
    link, placement = int(shape.parentJoint), shape.placement
    if arm.frames[shape.parentFrame].name == model.tool_frame:
        link, placement = arm.njoints, arm.frames[model.tcp_frame].placement.inverse() * placement
    (ax, ay, az), (bx, by, bz) = (placement.act(centre + side * half * axis).tolist() for side in (-1.0, 1.0))
    return CapsuleDescription(link, (ax, ay, az), (bx, by, bz), radius)


def _axis(geometry: coal.CollisionGeometry) -> tuple[Array, Array, float, float]:
    """Centre (3,) and direction (3,) of a capsule's axis in its body's frame, half its length and its radius, m."""
    if isinstance(geometry, coal.Capsule):
        return np.zeros(3), np.eye(3)[2], geometry.halfLength, geometry.radius
    if isinstance(geometry, coal.Sphere):
        return np.zeros(3), np.eye(3)[2], 0.0, geometry.radius
    geometry.computeLocalAABB()
    low, high = geometry.aabb_local.min_, geometry.aabb_local.max_
    sides = np.sort(high - low)
    radius = max(float(sides[:2].mean()) / 2, THINNEST_M)
    return (low + high) / 2, np.eye(3)[int(np.argmax(high - low))], max(float(sides[2]) / 2 - radius, 0.0), radius


def _length(capsule: CapsuleDescription) -> float:
    return float(np.linalg.norm(np.subtract(capsule.end, capsule.start))) + 2 * capsule.radius


def _volume(box: BoxDescription) -> float:
    return float(np.prod(np.subtract(box.upper, box.lower)))
