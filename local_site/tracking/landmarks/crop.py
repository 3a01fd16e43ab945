"""Square crops of a picture, turned so that a hand stands upright in them; pure."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled

BRIGHT_LEVEL = 165.0  # of the hand in the crop: the models see bright hands best
MOST_GAIN = 2.3
LEVELS = np.arange(256, dtype=np.float32)


@dataclass(frozen=True, slots=True)
class Crop:
    """A square of a picture: its centre (2,) in px, its side in px, and the angle in rad by which it is turned."""

    centre: Array
    side_px: float
    angle: float

    def changed(self, turn: float = 0.0, scale: float = 1.0) -> "Crop":
        """The same place, turned further by an angle in rad, and scaled."""
        return Crop(self.centre, scale * self.side_px, self.angle + turn)

    def to_picture(self, points: Array) -> Array:
        """Points (N, 2) of the crop, from 0 to 1, in px of the picture."""
        axes = self.side_px * _turned(self.angle)
        return self.centre + (points - 0.5) @ axes.T

    def cut(self, image: Image, size_px: int) -> NDArray[np.float32]:
        """The crop as RGB (size, size, 3) from 0 to 1, bright enough for the models; black outside the picture."""
        axes = self.side_px / size_px * _turned(self.angle)
        matrix = np.column_stack([axes, self.centre - axes @ np.full(2, (size_px - 1) / 2)])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        turned = cv2.warpAffine(image, matrix, (size_px, size_px), flags=flags, borderMode=cv2.BORDER_CONSTANT)
        return _brightened(np.asarray(turned, dtype=np.uint8), LEVELS)


@compiled
def _brightened(bgr: Image, levels: NDArray[np.float32]) -> NDArray[np.float32]:
    """A crop as RGB from 0 to 1, its core as bright as a well lit hand; nothing is darkened."""
    eighth = len(bgr) // 8
    total = 0
    for y in range(3 * eighth, 5 * eighth):
        for x in range(3 * eighth, 5 * eighth):
            total += max(bgr[y, x, 0], bgr[y, x, 1], bgr[y, x, 2])
    gain = min(max(BRIGHT_LEVEL * (2 * eighth) ** 2 / max(total, 1), 1.0), MOST_GAIN)
    table = np.minimum(levels * np.float32(gain / 255.0), np.float32(1.0))
    rgb = np.empty(bgr.shape, np.float32)
    for y in range(bgr.shape[0]):
        for x in range(bgr.shape[1]):
            for c in range(3):
                rgb[y, x, c] = table[bgr[y, x, 2 - c]]
    return rgb


def _turned(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def upright(tail: Array, head: Array) -> float:
    """The angle in rad of a crop in which the line from `tail` (2,) to `head` (2,) in px points up."""
    along = head - tail
    return math.atan2(float(along[0]), float(-along[1]))
