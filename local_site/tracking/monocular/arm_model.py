"""The arm: two links joined at the elbow, their pose in the camera's frame, and their meshes, rendered.

The meshes are closed and triangular, and scaled to lengths and girths (section 2.1.1 of the report).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from common.geometry import Array, rotation_from_vector, vector_from_rotation
from local_site.calibration.physical_camera import Lens
from local_site.kernels.rasterising import NOTHING, Triangles, rasterise
from local_site.tracking.config import ForearmConfig, UpperArmConfig
from local_site.tracking.monocular.picture import Box

DAMPING = 0.7
MM = 1e-3
RINGS, SECTORS = 24, 48
CAP_RINGS = 4
TURN = 2.0 * math.pi
MARGIN_PX = 24
DEPTH_STEP_PX = 2

Link = tuple[Array, Array]


@dataclass(frozen=True, slots=True)
class ArmPose:
    """The shoulder (3,) in m and `camera_R_link` (3, 3) of upper arm and forearm; links run along their z."""

    shoulder: Array
    upper_arm: Array
    forearm: Array
    upper_arm_length: float

    @property
    def elbow(self) -> Array:
        """The joint between the links (3,), m."""
        result: Array = self.shoulder + self.upper_arm_length * self.upper_arm[:, 2]
        return result

    @property
    def links(self) -> tuple[Link, Link]:
        """Joint (3,) and rotation (3, 3) of upper arm and forearm."""
        return (self.shoulder, self.upper_arm), (self.elbow, self.forearm)

    def on_upper_arm(self, point: Array) -> Array:
        """A point (3,) of the upper arm's frame in the camera's, m."""
        result: Array = self.shoulder + self.upper_arm @ point
        return result

    def on_forearm(self, point: Array) -> Array:
        """A point (3,) of the forearm's frame in the camera's, m."""
        result: Array = self.elbow + self.forearm @ point
        return result

    def moved(self, translation: Array, upper_turn: Array, forearm_turn: Array) -> "ArmPose":
        """The pose after a translation (3,) in m of the shoulder and small rotations (3,) in rad of both links, about
        the camera's axes (eq. 1-4)."""
        return ArmPose(
            self.shoulder + translation,
            rotation_from_vector(upper_turn) @ self.upper_arm,
            rotation_from_vector(forearm_turn) @ self.forearm,
            self.upper_arm_length,
        )


def predicted(before: ArmPose, last: ArmPose) -> ArmPose:
    """The next pose if the last motion continues, damped."""
    return last.moved(
        DAMPING * (last.shoulder - before.shoulder),
        DAMPING * vector_from_rotation(last.upper_arm @ before.upper_arm.T),
        DAMPING * vector_from_rotation(last.forearm @ before.forearm.T),
    )


def facing(along: Array, turn: float) -> Array:
    """`camera_R_link` of a link along a direction (3,) with its palm parallel to the image, rotated about it by `turn`
    in rad; undefined for a link along the optical axis."""
    z = along / np.linalg.norm(along)
    deep = np.array([0.0, 0.0, 1.0]) - z[2] * z
    deep /= np.linalg.norm(deep)
    rotation: Array = np.column_stack([np.cross(deep, z), deep, z]) @ rotation_from_vector(np.array([0.0, 0.0, turn]))
    return rotation


@dataclass(frozen=True, slots=True)
class Profile:
    """Half axes (N,) in m of the elliptic sections, across (x) and deep (y), at positions (N,) along the link in m."""

    along: Array
    across: Array
    deep: Array


@dataclass(frozen=True, slots=True)
class Mesh:
    """A link in its own frame: vertices (V, 3) in m, outward unit normals (V, 3), triangles (T, 3).

    The joint is the origin, z points along the link, x across the palm. `length` in m is from joint to joint;
    `sections` are those between the caps.
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
    """The forearm's mesh, round at the elbow and flat at the palm."""
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
    positions = np.linspace(profile.along[0], profile.along[-1], RINGS)
    halves = (PchipInterpolator(profile.along, half)(positions) for half in (profile.across, profile.deep))
    sections = Profile(positions, *halves)
    body = np.column_stack([sections.along, sections.across, sections.deep])
    first, *_, last = np.column_stack([profile.along, profile.across, profile.deep])
    rings = np.concatenate([_cap(first, -1.0)[::-1], body, _cap(last, 1.0)])
    turn = np.linspace(0.0, TURN, SECTORS, endpoint=False)
    across = rings[:, None, 1:] * np.column_stack([np.cos(turn), np.sin(turn)])
    along = np.broadcast_to(rings[:, None, :1], (*across.shape[:2], 1))
    points, triangles = np.concatenate([across, along], axis=2).reshape(-1, 3), _triangles(len(rings))
    return Mesh(points, _normals(points, triangles), triangles, length, sections)


def _cap(end: Array, sense: float) -> Array:
    """Rings (CAP_RINGS, 3), position and half axes in m, of half an ellipsoid beyond an end ring (3,) of the body."""
    angles = np.linspace(0.0, 0.5 * math.pi, CAP_RINGS + 1)[1:]
    narrowing, reach = np.maximum(np.cos(angles), 1e-3), sense * 0.5 * end[2] * np.sin(angles)
    return np.column_stack([end[0] + reach, end[1] * narrowing, end[2] * narrowing])


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


@dataclass(frozen=True, slots=True)
class Depths:
    """1 / depth (H, W) in 1/m in every DEPTH_STEP_PX-th pixel; focal lengths and principal point (2,) in its px."""

    inverse: Array
    focal: Array
    principal: Array


@dataclass(frozen=True, slots=True)
class Patch:
    """The visible part of one link in a part of the picture: pixels (N,) by row and column, points (N, 3) in m and
    normals (N, 3) in the link's frame, and the cosine (N,) of each normal to the line of sight, -n.v."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    points: Array
    normals: Array
    facing: Array


class ArmView:
    """Renders both meshes for a pinhole camera."""

    def __init__(self, lens: Lens, upper_arm: Mesh, forearm: Mesh) -> None:
        self._focal, self._principal = np.array([lens.fx, lens.fy]), np.array([lens.cx, lens.cy])
        self._meshes = (upper_arm, forearm)
        self._first = len(upper_arm.triangles)
        self._triangles = np.vstack([upper_arm.triangles, forearm.triangles + len(upper_arm.vertices)]).astype(np.int32)
        self._vertices = np.vstack([mesh.vertices for mesh in self._meshes])
        self._normals = np.vstack([mesh.normals for mesh in self._meshes])

    def box(self, pose: ArmPose, shape: tuple[int, ...]) -> Box | None:
        """The part of a picture (H, W) that contains the arm with a margin; None if it is out of the picture."""
        height, width = shape
        x, y, z = self._in_camera(pose).T.copy()
        if not (np.isfinite(z).all() and z.min() > 0):
            return None
        u, v = self._focal[0] * x / z + self._principal[0], self._focal[1] * y / z + self._principal[1]
        left, right = max(int(u.min()) - MARGIN_PX, 0), min(int(u.max()) + 1 + MARGIN_PX, width)
        top, bottom = max(int(v.min()) - MARGIN_PX, 0), min(int(v.max()) + 1 + MARGIN_PX, height)
        return (left, top, right, bottom) if min(right - left, bottom - top) >= 2 * MARGIN_PX else None

    def depths(self, pose: ArmPose, box: Box) -> Depths:
        """The depth map, for occlusion tests."""
        in_camera, step = self._in_camera(pose), DEPTH_STEP_PX
        pixels = (self._pixels(in_camera) - box[:2] + 0.5) / step - 0.5
        size = (box[2] - box[0]) // step, (box[3] - box[1]) // step
        raster = rasterise(pixels, in_camera[:, 2].copy(), self._triangles, *size)
        return Depths(raster.inverse_depth, self._focal / step, (self._principal - box[:2] + 0.5) / step - 0.5)

    def patches(self, pose: ArmPose, box: Box) -> list[Patch]:
        """The visible part of both links, in every pixel of a part of the picture."""
        in_camera = self._in_camera(pose)
        pixels = self._pixels(in_camera) - box[:2]
        size = box[2] - box[0], box[3] - box[1]
        raster = rasterise(pixels, in_camera[:, 2].copy(), self._triangles, *size)
        patches = []
        for is_upper, (joint, rotation) in zip((True, False), pose.links, strict=True):
            mine = (raster.triangle != NOTHING) & ((raster.triangle < self._first) == is_upper)
            corners, weights = self._triangles[raster.triangle[mine]], raster.barycentric[mine]
            points, normals = (np.einsum("nk,nkd->nd", weights, of[corners]) for of in (self._vertices, self._normals))
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            at = points @ rotation.T + joint
            towards = -np.sum(normals @ rotation.T * at, axis=1) / np.linalg.norm(at, axis=1)
            rows, columns = np.nonzero(mine)
            patches.append(Patch(rows, columns, points, normals, towards))
        return patches

    def _in_camera(self, pose: ArmPose) -> Array:
        """All vertices (V, 3) in the camera's frame, m."""
        links = zip(self._meshes, pose.links, strict=True)
        return np.vstack([mesh.vertices @ rotation.T + joint for mesh, (joint, rotation) in links])

    def _pixels(self, in_camera: Array) -> Array:
        pixels: Array = in_camera[:, :2] / in_camera[:, 2:] * self._focal + self._principal
        return pixels
