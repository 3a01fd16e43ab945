"""Rectangles in space, and the flat surfaces of room and table with their pictures."""

from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from remote_site.simulation.appearance.materials import Picture


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle seen from its front: lower left corner and the edges to the right and upwards (3,), m."""

    corner: Array
    right: Array
    up: Array

    @property
    def normal(self) -> Array:
        """The unit vector towards whoever sees the rectangle."""
        across = np.cross(self.right, self.up)
        return np.asarray(across / np.linalg.norm(across), dtype=float)

    @property
    def size_m(self) -> tuple[float, float]:
        """Height and width."""
        return float(np.linalg.norm(self.up)), float(np.linalg.norm(self.right))

    def shape(self, px_m: float) -> tuple[int, int]:
        """Rows and columns of a picture with so many pixels per metre."""
        height, width = self.size_m
        return max(2, round(height * px_m)), max(2, round(width * px_m))

    def points(self, shape: tuple[int, int]) -> Array:
        """The centres (H, W, 3) of the pixels of such a picture, top row first."""
        v = 1.0 - (np.arange(shape[0]) + 0.5) / shape[0]
        u = (np.arange(shape[1]) + 0.5) / shape[1]
        return np.asarray(self.corner + u[None, :, None] * self.right + v[:, None, None] * self.up, dtype=float)


@dataclass(frozen=True, slots=True)
class PaintedSurface:
    """A rectangle with its picture (H, W, 3), BGR, light included; of the table, or of the room behind everything."""

    rectangle: Rectangle
    picture: Image
    of_table: bool


def surface(rectangle: Rectangle, picture: Picture, light: np.ndarray, *, of_table: bool) -> PaintedSurface:
    """A surface of that material under that light (h, w), which may be coarser than the picture."""
    full = cv2.resize(light, picture.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    lit = cv2.multiply(picture, cv2.merge([full] * 3), scale=255.0, dtype=cv2.CV_8U)
    return PaintedSurface(rectangle, np.asarray(cv2.cvtColor(lit, cv2.COLOR_RGB2BGR), dtype=np.uint8), of_table)


def box_faces(low: Array, high: Array) -> dict[tuple[int, int], Rectangle]:
    """The six faces of an upright box by axis and side, from its lowest to its highest corner."""
    x, y, z = np.diag(high - low)
    return {
        (0, 1): Rectangle(np.array([high[0], low[1], low[2]]), y, z),
        (0, -1): Rectangle(np.array([low[0], high[1], low[2]]), -y, z),
        (1, 1): Rectangle(np.array([high[0], high[1], low[2]]), -x, z),
        (1, -1): Rectangle(np.array([low[0], low[1], low[2]]), x, z),
        (2, 1): Rectangle(np.array([high[0], low[1], high[2]]), y, -x),
        (2, -1): Rectangle(np.array([low[0], low[1], low[2]]), y, x),
    }


def box_corners(low: Array, high: Array) -> Array:
    """The eight corners (8, 3) of an upright box."""
    return np.array([(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
