"""Surfaces before a camera: rasterised, blurred by motion, as a layer that lies over a background."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.kernels.compiled import compiled
from local_site.kernels.rasterising import NOTHING, Triangles, rasterise

Picture = NDArray[np.float32]

FINE = 2  # samples a pixel, each way
LEAST_STEP_PX, MOST_EXPOSURES = 1.5, 5


@dataclass(frozen=True, slots=True)
class FilmLayer:
    """A part of a picture from `left`, `top`: BGR times alpha (h, w, 3) from 0 to 255, and alpha (h, w) from 0 to 1."""

    left: int
    top: int
    colour: Picture
    alpha: Picture

    def over(self, picture: Picture) -> None:
        """Lay it over a picture (H, W, 3), in place."""
        height, width = self.alpha.shape
        part = picture[self.top : self.top + height, self.left : self.left + width]
        part *= 1.0 - self.alpha[..., None]
        part += self.colour


def rendered(
    camera: PhysicalCamera, size: tuple[int, int], exposures: Sequence[Array], triangles: Triangles, colours: Array
) -> FilmLayer | None:
    """A surface during one exposure: its vertices (V, 3) at both ends of it, or once; None outside of the picture."""
    pixels = [camera.pixels(vertices) for vertices in exposures]
    moved = max(float(np.abs(pixels[-1] - pixels[0]).max()), 0.0)
    steps = min(1 + math.ceil(moved / LEAST_STEP_PX), MOST_EXPOSURES) if moved > 0.3 else 1
    box = _box(np.vstack(pixels), size)
    if box is None:
        return None
    left, top, right, bottom = box
    total = np.zeros((FINE * (bottom - top), FINE * (right - left), 4), np.float32)
    depths = [camera.to_camera(vertices)[:, 2] for vertices in exposures]
    for share in (np.arange(steps) + 0.5) / steps:
        at = (1.0 - share) * pixels[0] + share * pixels[-1]
        depth = (1.0 - share) * depths[0] + share * depths[-1]
        fine = FINE * (at - (left, top)) + (FINE - 1) / 2
        raster = rasterise(fine, depth, triangles, total.shape[1], total.shape[0])
        _add(raster.triangle, raster.barycentric, triangles, colours.astype(np.float32), 1.0 / steps, total)
    resized = cv2.resize(total, (right - left, bottom - top), interpolation=cv2.INTER_AREA)
    small: Picture = np.asarray(resized, dtype=np.float32)
    return FilmLayer(left, top, small[..., :3], small[..., 3])


def _box(pixels: Array, size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    low = np.clip(np.floor(pixels.min(axis=0)) - 1, 0, size).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)) + 2, 0, size).astype(int)
    return None if np.any(high <= low) else (int(low[0]), int(low[1]), int(high[0]), int(high[1]))


@compiled
def _add(
    numbers: NDArray[np.int32], weights: Array, triangles: Triangles, colours: Picture, share: float, total: Picture
) -> None:
    """Add the colours of a raster's pixels, and their share, to a picture with alpha."""
    height, width = numbers.shape
    for y in range(height):
        for x in range(width):
            if numbers[y, x] == NOTHING:
                continue
            a, b, c = triangles[numbers[y, x]]
            of_a, of_b, of_c = weights[y, x]
            for k in range(3):
                total[y, x, k] += share * (of_a * colours[a, k] + of_b * colours[b, k] + of_c * colours[c, k])
            total[y, x, 3] += share


def lay(layers: Sequence[FilmLayer | None], pictures: Sequence[Picture]) -> None:
    """Lay one layer over each picture, where there is one."""
    for layer, picture in zip(layers, pictures, strict=True):
        if layer is not None:
            layer.over(picture)
