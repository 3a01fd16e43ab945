"""The arm's silhouette in one image: its grey picture, its outer contour, where it meets the border (thesis 3.1.3)."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled

MIN_AREA_FRACTION = 1e-3
MIN_CONTOUR_POINTS = 40


@dataclass(frozen=True, slots=True)
class Silhouette:
    """The arm's blob: smoothed grey image (H, W), threshold level, ordered outer contour (N, 2) and area in px.

    Shadows within the contour are lifted above the level, so that they do not look like the arm's edge.
    """

    grey: NDArray[np.uint8]
    level: float
    contour: Array
    area: float

    def touches_border(self, points: Array) -> NDArray[np.bool_]:
        """Which pixels (N, 2) lie on the image border, (N,)."""
        return _on_border(points, *self.grey.shape)

    @property
    def at_border(self) -> bool:
        """Whether the image border cuts the arm."""
        return bool(self.touches_border(self.contour).any())


@compiled
def _on_border(points: Array, height: int, width: int) -> NDArray[np.bool_]:
    """Which pixels (N, 2) lie on the border of a picture of this size, (N,)."""
    touching = np.empty(len(points), np.bool_)
    for k in range(len(points)):
        x, y = points[k]
        touching[k] = x <= 1 or y <= 1 or x >= width - 2 or y >= height - 2
    return touching


def to_grey(image: Image) -> NDArray[np.uint8]:
    """The image as smoothed grey (H, W); colours are weighted as usual, other channel counts use the first."""
    if image.ndim == 3:
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.shape[2] == 3 else image[..., 0]
    else:
        grey = image
    return np.asarray(cv2.GaussianBlur(np.ascontiguousarray(grey), (3, 3), 0), dtype=np.uint8)


def find_silhouette(grey: NDArray[np.uint8], level: float) -> Silhouette | None:
    """The largest bright blob of a smoothed grey image, or None when none is large enough to be an arm."""
    mask = cv2.threshold(grey, level, 255, cv2.THRESH_BINARY)[1]
    contours = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    if not contours:
        return None
    largest = max(contours, key=cv2.contourArea)
    area = cv2.contourArea(largest)
    if area < MIN_AREA_FRACTION * grey.size or len(largest) < MIN_CONTOUR_POINTS:
        return None
    solid = np.zeros_like(grey)
    cv2.drawContours(solid, [largest], -1, math.ceil(level) + 1, cv2.FILLED)
    solid = np.asarray(cv2.max(solid, grey), dtype=np.uint8)
    return Silhouette(solid, level, largest.reshape(-1, 2).astype(np.float64), area)
