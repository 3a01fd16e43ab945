"""The arm's meshes before the camera: which part of the picture they fill, what hides what, what shows where."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.lens import Lens
from local_site.kernels.rasterising import NOTHING, Raster, rasterise
from local_site.tracking.monocular.arm_mesh import Mesh
from local_site.tracking.monocular.picture import Box
from local_site.tracking.monocular.pose import ArmPose, Link

MARGIN_PX = 24
DEPTH_STEP_PX = 2


@dataclass(frozen=True, slots=True)
class Depths:
    """1 / depth (H, W) in 1/m in every DEPTH_STEP_PX-th pixel; focal lengths and principal point (2,) in its px."""

    inverse: Array
    focal: Array
    principal: Array


@dataclass(frozen=True, slots=True)
class Patch:
    """What of one link shows in a part of the picture: pixels (N,) by row and column, points (N, 3) in m and normals
    (N, 3) in the link's frame, and how far each faces the camera (N,), -n.v."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    points: Array
    normals: Array
    facing: Array


class ArmView:
    """Two meshes before a pinhole camera."""

    def __init__(self, lens: Lens, upper_arm: Mesh, forearm: Mesh) -> None:
        self._focal, self._principal = np.array([lens.fx, lens.fy]), np.array([lens.cx, lens.cy])
        self._meshes = (upper_arm, forearm)
        self._first = len(upper_arm.triangles)
        self._triangles = np.vstack([upper_arm.triangles, forearm.triangles + len(upper_arm.vertices)]).astype(np.int32)
        self._vertices = np.vstack([mesh.vertices for mesh in self._meshes])
        self._normals = np.vstack([mesh.normals for mesh in self._meshes])

    def box(self, pose: ArmPose, width: int, height: int) -> Box | None:
        """The part of a picture of this size that holds the arm with a margin; None where it is out of the picture."""
        x, y, z = self._in_camera(pose).T.copy()
        if not (np.isfinite(z).all() and z.min() > 0):
            return None
        u, v = self._focal[0] * x / z + self._principal[0], self._focal[1] * y / z + self._principal[1]
        left, right = max(int(u.min()) - MARGIN_PX, 0), min(int(u.max()) + 1 + MARGIN_PX, width)
        top, bottom = max(int(v.min()) - MARGIN_PX, 0), min(int(v.max()) + 1 + MARGIN_PX, height)
        return (left, top, right, bottom) if min(right - left, bottom - top) >= 2 * MARGIN_PX else None

    def depths(self, pose: ArmPose, box: Box) -> Depths:
        """How deep the picture is, for telling what is hidden."""
        in_camera, step = self._in_camera(pose), DEPTH_STEP_PX
        pixels = (self._pixels(in_camera) - box[:2] + 0.5) / step - 0.5
        size = (box[2] - box[0]) // step, (box[3] - box[1]) // step
        raster = rasterise(pixels, in_camera[:, 2].copy(), self._triangles, *size)
        return Depths(raster.inverse_depth, self._focal / step, (self._principal - box[:2] + 0.5) / step - 0.5)

    def patches(self, pose: ArmPose, box: Box) -> tuple[Patch, Patch]:
        """What of both links shows in every pixel of a part of the picture."""
        in_camera = self._in_camera(pose)
        pixels = self._pixels(in_camera) - box[:2]
        size = box[2] - box[0], box[3] - box[1]
        raster = rasterise(pixels, in_camera[:, 2].copy(), self._triangles, *size)
        upper, forearm = (
            self._patch((raster.triangle != NOTHING) & ((raster.triangle < self._first) == is_upper), raster, link)
            for is_upper, link in zip((True, False), pose.links, strict=True)
        )
        return upper, forearm

    def _in_camera(self, pose: ArmPose) -> Array:
        """All vertices (V, 3) in the camera's frame, m."""
        links = zip(self._meshes, pose.links, strict=True)
        return np.vstack([mesh.vertices @ rotation.T + joint for mesh, (joint, rotation) in links])

    def _pixels(self, in_camera: Array) -> Array:
        pixels: Array = in_camera[:, :2] / in_camera[:, 2:] * self._focal + self._principal
        return pixels

    def _patch(self, mine: NDArray[np.bool_], raster: Raster, link: Link) -> Patch:
        rows, columns = np.nonzero(mine)
        corners, shares = self._triangles[raster.triangle[mine]], raster.barycentric[mine]
        points, normals = (np.einsum("nk,nkd->nd", shares, of[corners]) for of in (self._vertices, self._normals))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        joint, rotation = link
        in_camera = points @ rotation.T + joint
        towards = -np.sum(normals @ rotation.T * in_camera, axis=1) / np.linalg.norm(in_camera, axis=1)
        return Patch(rows, columns, points, normals, towards)
