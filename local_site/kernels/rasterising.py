"""Triangles to pixels: which triangle each pixel shows, and where in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled

NOTHING = -1

Triangles = NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Raster:
    """A picture of triangles: 1 / depth (H, W) in 1/m, 0 where there is nothing; the triangle's number (H, W), NOTHING
    likewise; and the barycentric coordinates (H, W, 3) of the surface point, corrected for perspective."""

    inverse_depth: Array
    triangle: NDArray[np.int32]
    barycentric: Array


def rasterise(pixels: Array, depths: Array, triangles: Triangles, width: int, height: int) -> Raster:
    """The nearest triangles of vertices at pixels (V, 2) and depths (V,) in m; those seen from behind are left out.

    A triangle (T, 3) faces the camera when its corners go round anticlockwise in the picture as people see it.
    """
    raster = Raster(
        np.zeros((height, width)), np.full((height, width), NOTHING, np.int32), np.zeros((height, width, 3))
    )
    _fill(pixels, 1.0 / depths, triangles, raster.inverse_depth, raster.triangle, raster.barycentric)
    return raster


@compiled
def _fill(
    pixels: Array, nearness: Array, triangles: Triangles, inverse_depth: Array, numbers: NDArray[np.int32], out: Array
) -> None:
    height, width = inverse_depth.shape
    for t in range(len(triangles)):
        a, b, c = triangles[t]
        ax, ay = pixels[a]
        bx, by = pixels[b]
        cx, cy = pixels[c]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not area < 0.0:
            continue
        left, right = max(int(np.ceil(min(ax, bx, cx))), 0), min(int(np.floor(max(ax, bx, cx))), width - 1)
        top, bottom = max(int(np.ceil(min(ay, by, cy))), 0), min(int(np.floor(max(ay, by, cy))), height - 1)
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                of_b = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
                of_c = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
                of_a = 1.0 - of_b - of_c
                if of_a < 0.0 or of_b < 0.0 or of_c < 0.0:
                    continue
                near = of_a * nearness[a] + of_b * nearness[b] + of_c * nearness[c]
                if near > inverse_depth[y, x]:
                    inverse_depth[y, x], numbers[y, x] = near, t
                    out[y, x, 0] = of_a * nearness[a] / near
                    out[y, x, 1] = of_b * nearness[b] / near
                    out[y, x, 2] = of_c * nearness[c] / near
