"""A lens: focal lengths, principal point and radial distortion, between the picture taken and a pinhole's picture."""

from typing import Annotated

import cv2
import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from common.geometry import Array

NEWTON_STEPS = 12

Maps = tuple[NDArray[np.int16], NDArray[np.uint16]]


class Lens(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Focal lengths and principal point in px; k1, k2 bend slopes r = (x/z, y/z) to r (1 + k1 |r|² + k2 |r|⁴)."""

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

    def distort_pixels(self, pixels: Array) -> Array:
        """Pixels (..., 2) in the picture taken, of pixels (..., 2) in a pinhole's picture."""
        slopes = self._slopes(pixels)
        return self._pixels(slopes * self._stretch(np.sum(slopes * slopes, axis=-1, keepdims=True)))

    def undistort_pixels(self, pixels: Array) -> Array:
        """Pixels (..., 2) in a pinhole's picture, of pixels (..., 2) in the picture taken; NaN stays NaN."""
        if self.k1 == 0.0 and self.k2 == 0.0:
            return np.array(pixels, dtype=np.float64)
        bent = self._slopes(pixels)
        radius = np.linalg.norm(bent, axis=-1, keepdims=True)
        straight = radius.copy()
        for _ in range(NEWTON_STEPS):
            square = straight * straight
            slope = 1.0 + square * (3.0 * self.k1 + 5.0 * self.k2 * square)
            straight -= (straight * self._stretch(square) - radius) / np.where(np.abs(slope) < 0.1, 0.1, slope)
        return self._pixels(bent / self._stretch(straight * straight))

    def undistortion_maps(self, width: int, height: int) -> Maps:
        """Fixed-point maps for `cv2.remap` that turn a picture of this size into a pinhole's with the same matrix."""
        bending = np.array([self.k1, self.k2, 0.0, 0.0])
        maps = cv2.initUndistortRectifyMap(self.matrix, bending, np.eye(3), self.matrix, (width, height), cv2.CV_16SC2)
        return np.asarray(maps[0], dtype=np.int16), np.asarray(maps[1], dtype=np.uint16)

    def folds_within(self, radius: float) -> bool:
        """Whether the picture turns back on itself before this slope from the axis: such a lens cannot be undone."""
        squares = np.linspace(0.0, radius, 64) ** 2
        return bool(np.any(1.0 + squares * (3.0 * self.k1 + 5.0 * self.k2 * squares) <= 0.0))

    def _stretch(self, square: Array) -> Array:
        return 1.0 + square * (self.k1 + self.k2 * square)

    def _slopes(self, pixels: Array) -> Array:
        return (np.asarray(pixels, dtype=np.float64) - (self.cx, self.cy)) / (self.fx, self.fy)

    def _pixels(self, slopes: Array) -> Array:
        result: Array = slopes * (self.fx, self.fy) + (self.cx, self.cy)
        return result
