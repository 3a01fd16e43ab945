"""An image pyramid of two levels around the arm: smoothed grey levels and gradients, fine and coarse."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.physical_camera import Lens
from local_site.kernels.pictures import Levels

FINE_BLUR_PX, COARSE_BLUR_PX = 0.8, 1.0
COARSE = 4

Box = tuple[int, int, int, int]


class PyramidLevel(NamedTuple):
    """A part of the frame at some resolution: grey levels and their gradients per px of the level (H, W), focal lengths
    (2,) and principal point (2,) in its px."""

    grey: Levels
    along_x: Levels
    along_y: Levels
    focal: Array
    principal: Array


def fine_level(image: Image, lens: Lens, box: Box) -> PyramidLevel:
    """The part (left, top, right, bottom) of a grey frame (H, W) at full resolution."""
    left, top, right, bottom = box
    grey = cv2.GaussianBlur(image[top:bottom, left:right].astype(np.float32), (0, 0), FINE_BLUR_PX)
    return _level(grey, np.array([lens.fx, lens.fy]), np.array([lens.cx - left, lens.cy - top]))


def coarse_level(image: Image, lens: Lens, box: Box) -> PyramidLevel:
    """The same part with COARSE times fewer pixels along each side."""
    left, top, right, bottom = box
    right, bottom = left + (right - left) // COARSE * COARSE, top + (bottom - top) // COARSE * COARSE
    size = ((right - left) // COARSE, (bottom - top) // COARSE)
    grey = cv2.resize(image[top:bottom, left:right].astype(np.float32), size, interpolation=cv2.INTER_AREA)
    grey = cv2.GaussianBlur(grey, (0, 0), COARSE_BLUR_PX)
    # Corner (0, 0) of a picture is the centre of its first pixel, at every resolution.
    principal = in_coarse_px(np.array([lens.cx - left, lens.cy - top]))
    return _level(grey, np.array([lens.fx, lens.fy]) / COARSE, principal)


def _level(grey: cv2.typing.MatLike, focal: Array, principal: Array) -> PyramidLevel:
    """Gradients by Sobel's operator, whose sums are eight times the gradient."""
    picture = np.asarray(grey, dtype=np.float32)
    along_x, along_y = (
        np.asarray(cv2.Sobel(picture, cv2.CV_32F, dx, dy, scale=0.125), dtype=np.float32) for dx, dy in ((1, 0), (0, 1))
    )
    return PyramidLevel(picture, along_x, along_y, focal, principal)


def in_coarse_px(pixels: Array | NDArray[np.intp]) -> Array:
    """Coordinates (N,) in px of a part of the frame, in px of its coarse level."""
    coarse: Array = (pixels + 0.5) / COARSE - 0.5
    return coarse
