"""A physical camera: a lens with radial distortion at a pose, and the steps of a fit."""

from dataclasses import dataclass, replace
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from scipy.linalg import rq
from scipy.spatial.transform import Rotation

from common.geometry import Array

NEWTON_STEPS = 12


class Lens(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Focal lengths and principal point in px; k1, k2 distort slopes r = (x/z, y/z) to r (1 + k1 |r|² + k2 |r|⁴)."""

    fx: Annotated[float, Meta(gt=0, description="focal length along the rows, px")]
    fy: Annotated[float, Meta(gt=0, description="focal length along the columns, px")]
    cx: Annotated[float, Meta(description="principal point, px from the left")]
    cy: Annotated[float, Meta(description="principal point, px from the top")]
    k1: Annotated[float, Meta(description="radial distortion, second order")] = 0.0
    k2: Annotated[float, Meta(description="radial distortion, fourth order")] = 0.0

    @property
    def matrix(self) -> Array:
        """The camera matrix K (3, 3), from slopes to pixels."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def is_distorted(self) -> bool:
        """Return whether the lens differs from a pinhole."""
        return self.k1 != 0.0 or self.k2 != 0.0

    def distort_pixels(self, pixels: Array) -> Array:
        """Pixels (..., 2) in the picture taken, of pixels (..., 2) in a pinhole's picture."""
        slopes = self._slopes(pixels)
        return self._pixels(slopes * self._stretch(np.sum(slopes * slopes, axis=-1, keepdims=True)))

    def undistort_pixels(self, pixels: Array) -> Array:
        """Pixels (..., 2) in a pinhole's picture, of pixels (..., 2) in the picture taken; NaN stays NaN."""
        if not self.is_distorted:
            return np.array(pixels, dtype=np.float64)
        distorted = self._slopes(pixels)
        radius = np.linalg.norm(distorted, axis=-1, keepdims=True)
        undistorted = radius.copy()
        for _ in range(NEWTON_STEPS):
            square = undistorted * undistorted
            slope = 1.0 + square * (3.0 * self.k1 + 5.0 * self.k2 * square)
            undistorted -= (undistorted * self._stretch(square) - radius) / np.where(np.abs(slope) < 0.1, 0.1, slope)
        return self._pixels(distorted / self._stretch(undistorted * undistorted))

    def folds_within(self, radius: float) -> bool:
        """Return whether the distortion is not monotonic up to this slope from the axis: such a lens has no inverse."""
        squares = np.linspace(0.0, radius, 64) ** 2
        return bool(np.any(1.0 + squares * (3.0 * self.k1 + 5.0 * self.k2 * squares) <= 0.0))

    def _stretch(self, square: Array) -> Array:
        return 1.0 + square * (self.k1 + self.k2 * square)

    def _slopes(self, pixels: Array) -> Array:
        return (np.asarray(pixels, dtype=np.float64) - (self.cx, self.cy)) / (self.fx, self.fy)

    def _pixels(self, slopes: Array) -> Array:
        return slopes * (self.fx, self.fy) + (self.cx, self.cy)


# What a fit may move, in the order of a step: both focal lengths (px), principal point (px), rotation (rad),
# translation (m), then what only some cameras need: fy beyond fx (px), k1, k2.
BASE = tuple(range(9))
ASPECT, K1, K2 = 9, 10, 11
NUMBERS = 12


@dataclass(frozen=True, slots=True)
class PhysicalCamera:
    """A lens, `camera_R_operator` (3, 3) and `translation` (3,) in m: camera = R operator + t, z along the view."""

    lens: Lens
    camera_R_operator: Array
    translation: Array

    @property
    def projection(self) -> Array:
        """The pinhole's projection (3, 4), from m in the operator frame to undistorted pixels."""
        return self.lens.matrix @ np.column_stack([self.camera_R_operator, self.translation])

    @property
    def centre(self) -> Array:
        """The camera's centre (3,) in m in the operator frame."""
        return -self.camera_R_operator.T @ self.translation

    def to_camera(self, points: Array) -> Array:
        """Points (..., 3) of the operator frame in the camera's frame, m."""
        return points @ self.camera_R_operator.T + self.translation

    def pixels(self, points: Array) -> Array:
        """Pixels (..., 2) in the picture taken, of points (..., 3) in m in the operator frame."""
        in_camera = self.to_camera(points)
        slopes = in_camera[..., :2] / in_camera[..., 2:]
        lens = self.lens
        return lens.distort_pixels(slopes * (lens.fx, lens.fy) + (lens.cx, lens.cy))

    def stepped(self, step: Array) -> "PhysicalCamera":
        """The camera a step (NUMBERS,) away."""
        turn = Rotation.from_rotvec(step[3:6]).as_matrix()
        lens = self.lens
        focal, cx, cy, aspect, k1, k2 = (float(value) for value in step[[0, 1, 2, ASPECT, K1, K2]])
        return PhysicalCamera(
            lens=Lens(
                lens.fx + focal, lens.fy + focal + aspect, lens.cx + cx, lens.cy + cy, lens.k1 + k1, lens.k2 + k2
            ),
            camera_R_operator=turn @ self.camera_R_operator,
            translation=self.translation + step[6:9],
        )

    def simplified(self, free: tuple[int, ...]) -> "PhysicalCamera":
        """The camera with square pixels, no k1 or no k2 where `free` does not hold their numbers."""
        lens = self.lens
        mean = (lens.fx + lens.fy) / 2
        fx, fy = (lens.fx, lens.fy) if ASPECT in free else (mean, mean)
        k1, k2 = (lens.k1 if K1 in free else 0.0), (lens.k2 if K2 in free else 0.0)
        return replace(self, lens=Lens(fx, fy, lens.cx, lens.cy, k1, k2))

    def in_frame(self, old_R_new: Array, old_t_new: Array) -> "PhysicalCamera":
        """The same camera, with a new operator frame given by its pose in the old one."""
        return replace(
            self,
            camera_R_operator=self.camera_R_operator @ old_R_new,
            translation=self.camera_R_operator @ old_t_new + self.translation,
        )


def decomposed(projection: Array) -> PhysicalCamera | None:
    """The pinhole camera nearest to a projection (3, 4) with positive depths; None if only a mirrored one would do."""
    if np.linalg.det(projection[:, :3]) <= 0:
        return None
    upper, orthogonal = rq(projection[:, :3])
    signs = np.sign(np.diag(upper))
    k = np.asarray(upper * signs, dtype=np.float64)
    rotation = np.asarray(signs[:, None] * orthogonal, dtype=np.float64)
    translation = np.asarray(np.linalg.solve(k, projection[:, 3]), dtype=np.float64)
    k = k / k[2, 2]
    return PhysicalCamera(Lens(float(k[0, 0]), float(k[1, 1]), float(k[0, 2]), float(k[1, 2])), rotation, translation)
