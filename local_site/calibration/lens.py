"""A lens: focal lengths, principal point and radial distortion, and the undistortion of pixels and pictures."""

from typing import Annotated

import cv2
import msgspec
import numpy as np
from msgspec import Meta

from common.cameras.camera import Image
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
        """Whether it is no pinhole."""
        return self.k1 != 0.0 or self.k2 != 0.0

    def distort_pixels(self, pixels: Array) -> Array:
        """Pixels (..., 2) in the picture taken, of pixels (..., 2) in a pinhole's picture."""
        slopes = self._slopes(pixels)
        return self._pixels(slopes * self._stretch(np.sum(slopes * slopes, axis=-1, keepdims=True)))

    def undistort_pixels(self, pixels: Array) -> Array:
        """Pixels (..., 2) in a pinhole's picture, of pixels (..., 2) in the picture taken; NaN stays NaN."""
        if not self.is_distorted:
            return np.array(pixels, dtype=np.float64)
        bent = self._slopes(pixels)
        radius = np.linalg.norm(bent, axis=-1, keepdims=True)
        straight = radius.copy()
        for _ in range(NEWTON_STEPS):
            square = straight * straight
            slope = 1.0 + square * (3.0 * self.k1 + 5.0 * self.k2 * square)
            straight -= (straight * self._stretch(square) - radius) / np.where(np.abs(slope) < 0.1, 0.1, slope)
        return self._pixels(bent / self._stretch(straight * straight))

    def folds_within(self, radius: float) -> bool:
        """Whether the distortion is not monotonic up to this slope from the axis: such a lens cannot be inverted."""
        squares = np.linspace(0.0, radius, 64) ** 2
        return bool(np.any(1.0 + squares * (3.0 * self.k1 + 5.0 * self.k2 * squares) <= 0.0))

    def _stretch(self, square: Array) -> Array:
        return 1.0 + square * (self.k1 + self.k2 * square)

    def _slopes(self, pixels: Array) -> Array:
        return (np.asarray(pixels, dtype=np.float64) - (self.cx, self.cy)) / (self.fx, self.fy)

    def _pixels(self, slopes: Array) -> Array:
        result: Array = slopes * (self.fx, self.fy) + (self.cx, self.cy)
        return result


class Undistorter:
    """Undistorts the pictures of one camera; the maps are computed once for each size of picture."""

    def __init__(self, lens: Lens | None, border: int) -> None:
        """`border` is how OpenCV fills pixels from outside the picture."""
        self._lens, self._border = lens, border
        self._maps: tuple[cv2.typing.MatLike, cv2.typing.MatLike] | None = None

    def undistorted(self, grey: Image) -> Image:
        """The picture (H, W) that a pinhole camera with the same matrix would have taken."""
        if self._lens is None or not self._lens.is_distorted:
            return grey
        if self._maps is None or self._maps[0].shape[:2] != grey.shape:
            matrix, distortion = self._lens.matrix, np.array([self._lens.k1, self._lens.k2, 0.0, 0.0])
            size = grey.shape[1], grey.shape[0]
            self._maps = cv2.initUndistortRectifyMap(matrix, distortion, np.eye(3), matrix, size, cv2.CV_16SC2)
        return np.asarray(cv2.remap(grey, *self._maps, cv2.INTER_LINEAR, borderMode=self._border), dtype=np.uint8)
