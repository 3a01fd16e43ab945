"""The arm as two closed triangular meshes, scaled to lengths and girths (section 2.1.1 of the report)."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from common.geometry import Array
from local_site.kernels.rasterising import Triangles
from local_site.tracking.monocular.config import ForearmConfig, UpperArmConfig

MM = 1e-3
RINGS, SECTORS = 24, 48
CAP_RINGS = 4
TURN = 2.0 * math.pi


@dataclass(frozen=True, slots=True)
class Profile:
    """Half axes (N,) in m of the elliptic sections, across (x) and deep (y), at places (N,) along the link in m."""

    along: Array
    across: Array
    deep: Array


@dataclass(frozen=True, slots=True)
class Mesh:
    """A link in its own frame: vertices (V, 3) in m, outward unit normals (V, 3), triangles (T, 3).

    The joint is the origin, z runs along the link, x across the palm. `length` in m is from joint to joint; `sections`
    are those between the caps.
    """

    vertices: Array
    normals: Array
    triangles: Triangles
    length: float
    sections: Profile


def upper_arm_mesh(config: UpperArmConfig) -> Mesh:
    """The upper arm's mesh, round."""
    girths = (config.shoulder_girth_mm, config.biceps_girth_mm, config.elbow_girth_mm)
    radii = MM * np.array(girths) / TURN
    length = MM * config.length_mm
    return _mesh(Profile(length * np.array([0.0, 0.5, 1.0]), radii, radii), length)


def forearm_mesh(config: ForearmConfig) -> Mesh:
    """The forearm's mesh, round, which goes over into the flat palm."""
    girths = (config.elbow_girth_mm, config.belly_girth_mm, config.wrist_girth_mm)
    radii = MM * np.array(girths) / TURN
    length, palm = MM * config.length_mm, MM * config.palm_length_mm
    along = np.array([0.0, 0.25 * length, length, length + 0.6 * palm, length + palm])
    width, thickness = 0.5 * MM * config.palm_width_mm, 0.5 * MM * config.palm_thickness_mm
    across = np.array([*radii, width, 0.9 * width])
    deep = np.array([*radii, thickness, 0.8 * thickness])
    return _mesh(Profile(along, across, deep), length)


def _mesh(profile: Profile, length: float) -> Mesh:
    """Rings along the link, and round caps that close it."""
    sections = _sections(profile)
    body = list(zip(sections.along.tolist(), sections.across.tolist(), sections.deep.tolist(), strict=True))
    rings = [*_cap(profile, at_end=False), *body, *_cap(profile, at_end=True)]
    turn = np.linspace(0.0, TURN, SECTORS, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    z = np.array([ring[0] for ring in rings])
    halves = np.array([ring[1:] for ring in rings])
    across = halves[:, None, :] * circle[None]
    vertices = np.concatenate([across, np.broadcast_to(z[:, None, None], (*across.shape[:2], 1))], axis=2)
    points, triangles = vertices.reshape(-1, 3), _triangles(len(rings))
    return Mesh(points, _normals(points, triangles), triangles, length, sections)


def _sections(profile: Profile) -> Profile:
    places = np.linspace(profile.along[0], profile.along[-1], RINGS)
    return Profile(places, *(PchipInterpolator(profile.along, half)(places) for half in (profile.across, profile.deep)))


def _cap(profile: Profile, at_end: bool) -> list[tuple[float, float, float]]:
    """Half an ellipsoid beyond an end of the body, half as long as the section is deep."""
    k, way = (-1, 1.0) if at_end else (0, -1.0)
    angles = np.linspace(0.0, 0.5 * math.pi, CAP_RINGS + 1)[1:]
    narrowing, reach = np.maximum(np.cos(angles), 1e-3), way * 0.5 * profile.deep[k] * np.sin(angles)
    rings = [
        (float(profile.along[k] + r), float(profile.across[k] * n), float(profile.deep[k] * n))
        for n, r in zip(narrowing, reach, strict=True)
    ]
    return rings if at_end else rings[::-1]


def _triangles(rings: int) -> Triangles:
    """Two triangles for each patch between neighbouring rings, anticlockwise as seen from outside."""
    first = np.arange(rings - 1)[:, None] * SECTORS
    sector, following = np.arange(SECTORS), (np.arange(SECTORS) + 1) % SECTORS
    a, b = first + sector, first + following
    c, d = a + SECTORS, b + SECTORS
    corners = np.stack([np.stack([a, b, d], -1), np.stack([a, d, c], -1)])
    return corners.reshape(-1, 3).astype(np.int32)


def _normals(points: Array, triangles: Triangles) -> Array:
    """Unit normals of the vertices, the mean of their triangles'."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    sums = np.zeros_like(points)
    for k in range(3):
        np.add.at(sums, triangles[:, k], faces)
    normals: Array = sums / np.linalg.norm(sums, axis=1, keepdims=True)
    return normals
