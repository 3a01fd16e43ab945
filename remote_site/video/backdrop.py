"""The flat surfaces of a simulated cell, seen by a camera: each picture is brought into the view by its homography.

OpenCV maps a plane several times faster than Mesa's software renderer fills a textured one, and one of four channels
twice as fast as one of three.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from remote_site.simulation.dressing import PaintedSurface, Rectangle

NEAR_M = 0.02
SMALLEST_PX = 32
BAND_PX = 32  # rows that are mapped together
SUBPIXEL_BITS = 4
FARTHEST_PX = 1e4


@dataclass(frozen=True, slots=True)
class Eye:
    """A camera without distortion: where it is, how it is turned (y down, z forward), its focal length and size, px."""

    position: Array
    world_R_image: Array
    focal_px: float
    width: int
    height: int

    def seen(self, points: Array) -> Array:
        """World points (n, 3) or directions from the camera as homogeneous pixels (n, 3)."""
        u, v, focal = self.width / 2, self.height / 2, self.focal_px
        ray_to_pixel = np.array([[focal, 0.0, 0.0], [0.0, focal, 0.0], [u, v, 1.0]])
        return np.asarray(points @ (self.world_R_image @ ray_to_pixel), dtype=float)


class Backdrop:
    """Draws the surfaces of a cell, of the room or of the table, wherever a mask says that they can be seen."""

    def __init__(self, surfaces: Sequence[PaintedSurface]) -> None:
        self._drawn = {of_table: [_Drawn(s) for s in surfaces if s.of_table == of_table] for of_table in (False, True)}

    def draw(self, eye: Eye, picture: Image, where: Image, *, of_table: bool) -> None:
        """Paint the surfaces into the picture (H, W, 4), RGBA, where the mask (H, W) is not 0."""
        left, top, width, height = cv2.boundingRect(where)
        if width:
            area = (left, top), (left + width, top + height)
            for surface in self._drawn[of_table]:
                surface.draw(eye, picture, where, area)


class _Drawn:
    """One surface with its picture in several sizes, each half as large as the one before."""

    def __init__(self, surface: PaintedSurface) -> None:
        self._corners = _corners(surface.rectangle)
        self._normal = surface.rectangle.normal
        self._levels = _pyramid(surface.picture)
        # The room is far away, and there neighbouring pixels show different texels in any case.
        self._filter = cv2.INTER_LINEAR if surface.of_table else cv2.INTER_NEAREST

    def draw(self, eye: Eye, picture: Image, where: Image, area: tuple[tuple[int, int], tuple[int, int]]) -> None:
        """Paint it where the mask is not 0, which it is within this area, from left and top to right and bottom."""
        if (eye.position - self._corners[0]) @ self._normal <= 0.0:
            return
        seen = eye.seen(self._corners - eye.position)
        outline = _outline(seen)
        low = np.maximum(np.floor(outline.min(axis=0, initial=FARTHEST_PX)).astype(int), area[0])
        high = np.minimum(np.ceil(outline.max(axis=0, initial=-FARTHEST_PX)).astype(int) + 1, area[1])
        if (high <= low).any():
            return
        window = (slice(low[1], high[1]), slice(low[0], high[0]))
        mask = np.zeros((high[1] - low[1], high[0] - low[0]), dtype=np.uint8)
        shape = np.rint((outline - low) * 2**SUBPIXEL_BITS).astype(np.int32)
        cv2.fillConvexPoly(mask, shape, 255, cv2.LINE_8, SUBPIXEL_BITS)
        mask &= where[window]
        left, top, width, height = cv2.boundingRect(mask)
        if width:
            level = self._level(seen, (low[0] + left + width / 2, low[1] + top + height / 2))
            for row in range(top, top + height, BAND_PX):  # much of a slanting surface's rectangle is of another one
                band = mask[row : min(row + BAND_PX, top + height)]
                self._draw_band(picture[low[1] + row :, low[0] :], band, level, (int(low[0]), int(low[1]) + row))

    def _draw_band(self, picture: Image, mask: Image, level: tuple[Image, Array], at: tuple[int, int]) -> None:
        """Paint where the mask is not 0, into a part of the picture that begins at this column and row."""
        left, top, width, height = cv2.boundingRect(mask)
        if not width:
            return
        texture, image_H_texture = level
        shift = np.array([[1.0, 0.0, -at[0] - left], [0.0, 1.0, -at[1] - top], [0.0, 0.0, 1.0]])
        shown = cv2.warpPerspective(
            texture, shift @ image_H_texture, (width, height), flags=self._filter, borderMode=cv2.BORDER_REPLICATE
        )
        part = (slice(top, top + height), slice(left, left + width))
        cv2.copyTo(shown, mask[part], picture[part])

    def _level(self, seen: Array, at: tuple[float, float]) -> tuple[Image, Array]:
        """The picture whose pixels are about as large as the view's at that place, and its homography to the view."""
        homography = _homography(seen, self._levels[0])
        nearness = abs(np.linalg.inv(homography)[2] @ (*at, 1.0))  # 1 / depth
        px_per_texel = math.sqrt(abs(np.linalg.det(homography)) * nearness**3)
        k = min(max(0, round(-math.log2(max(px_per_texel, 1e-6)))), len(self._levels) - 1)
        return self._levels[k], homography if k == 0 else _homography(seen, self._levels[k])


def _outline(seen: Array) -> Array:
    """The outline (n, 2) in pixels' centres of corners in homogeneous pixels, what lies behind the camera cut away."""
    corners, kept = seen.tolist(), []
    for here, there in zip(corners, corners[1:] + corners[:1], strict=True):
        if here[2] > NEAR_M:
            kept.append(here)
        if (here[2] > NEAR_M) != (there[2] > NEAR_M):
            part = (NEAR_M - here[2]) / (there[2] - here[2])
            kept.append([a + (b - a) * part for a, b in zip(here, there, strict=True)])
    places = [(_cut(x / depth - 0.5), _cut(y / depth - 0.5)) for x, y, depth in kept]
    return np.array(places, dtype=float).reshape(-1, 2)


def _cut(px: float) -> float:
    return min(max(px, -FARTHEST_PX), FARTHEST_PX)


def _corners(rectangle: Rectangle) -> Array:
    low, right, up = rectangle.corner, rectangle.right, rectangle.up
    return np.array([low, low + right, low + right + up, low + up])


def _homography(seen: Array, texture: Image) -> Array:
    """From pixels of a texture to the view's, by where the corners of its rectangle are seen, homogeneous px (4, 3)."""
    height, width = texture.shape[:2]
    right, down = (seen[1] - seen[0]) / width, (seen[0] - seen[3]) / height
    homography = np.array([right, down, seen[3] + (right + down) / 2]).T
    homography[:2] -= 0.5 * homography[2]  # pixels are counted from the middle of the first
    return homography


def _pyramid(picture: Image) -> list[Image]:
    levels = [np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGBA), dtype=np.uint8)]
    while min(levels[-1].shape[:2]) > 2 * SMALLEST_PX:
        half = (levels[-1].shape[1] // 2, levels[-1].shape[0] // 2)
        levels.append(np.asarray(cv2.resize(levels[-1], half, interpolation=cv2.INTER_AREA), dtype=np.uint8))
    return levels
