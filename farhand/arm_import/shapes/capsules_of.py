"""Geometries of a URDF in terms of capsules, and capsules in terms of a URDF's geometries; pure."""

import itertools
from collections.abc import Iterable

import numpy as np

from common.geometry import Array, transform
from farhand.arm_import.description.elements import Cylinder, Geometry, Shape, Sphere, UrdfBox, UrdfMesh
from farhand.arm_import.shapes.capsule import Capsule, enclosing_capsule

LEAST_LENGTH_M = 1e-6


def shape_of(capsule: Capsule) -> Shape:
    """A cylinder, which counts as the capsule around it, or a sphere where it has no length."""
    along = capsule.end - capsule.start
    length = float(np.sqrt(along @ along))
    middle = (capsule.start + capsule.end) / 2
    if length < LEAST_LENGTH_M:
        return Shape(transform(np.eye(3), middle), Sphere(capsule.radius))
    return Shape(transform(rotation_to(along / length), middle), Cylinder(capsule.radius, length))


def capsules_of(shapes: Iterable[Shape]) -> list[Capsule]:
    """Capsules around geometries that are no meshes, in the link's frame: one around all boxes, one for each other."""
    shapes = list(shapes)
    boxes = [_corners(shape.geometry, shape.link_T_shape) for shape in shapes if isinstance(shape.geometry, UrdfBox)]
    others = [capsule_of(shape) for shape in shapes if not isinstance(shape.geometry, UrdfBox)]
    return [*others, *([enclosing_capsule(np.concatenate(boxes))] if boxes else [])]


def capsule_of(shape: Shape) -> Capsule:
    """The capsule around a geometry that is no mesh, in the link's frame."""
    geometry, pose = shape.geometry, shape.link_T_shape
    if isinstance(geometry, UrdfBox):
        return enclosing_capsule(_corners(geometry, pose))
    half = _half_length(geometry) * pose[:3, 2]
    return Capsule(pose[:3, 3] - half, pose[:3, 3] + half, _radius(geometry))


def outermost(shape: Shape) -> Array:
    """Points (m x 3) in the link's frame between which a geometry lies that is no mesh."""
    geometry, pose = shape.geometry, shape.link_T_shape
    if isinstance(geometry, UrdfBox):
        return _corners(geometry, pose)
    radius = _radius(geometry)
    half = _half_length(geometry) or radius
    return _corners(UrdfBox((2 * radius, 2 * radius, 2 * half)), pose)


def _corners(box: UrdfBox, pose: Array) -> Array:
    corners = np.array(list(itertools.product(*((-edge / 2, edge / 2) for edge in box.size_m))))
    placed: Array = corners @ pose[:3, :3].T + pose[:3, 3]
    return placed


def _half_length(geometry: Geometry) -> float:
    return geometry.length_m / 2 if isinstance(geometry, Cylinder) else 0.0


def _radius(geometry: Geometry) -> float:
    if isinstance(geometry, UrdfMesh | UrdfBox):
        raise TypeError(f"{geometry} has no radius")
    return geometry.radius_m


def rotation_to(axis: Array) -> Array:
    """A rotation (3 x 3) whose z is along a unit axis."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(helper, axis)
    x /= np.sqrt(x @ x)
    return np.column_stack([x, np.cross(axis, x), axis])
