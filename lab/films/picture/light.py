"""Light on surfaces: normals, a window and a lamp, hollows that are darker, and the levels that a picture shows."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.kernels.rasterising import Triangles

AMBIENT, KEY, FILL = 0.42, 0.62, 0.25
CAVITY, DARKEST = 160.0, 0.55


@dataclass(frozen=True, slots=True)
class Lighting:
    """The directions (3,) towards a window and towards a weaker lamp, unit, in the operator frame."""

    window: Array
    lamp: Array


def linear(srgb: Array) -> Array:
    """Linear light from 0 to 1, of sRGB from 0 to 255."""
    unit = np.asarray(srgb, float) / 255.0
    return np.where(unit <= 0.04045, unit / 12.92, ((unit + 0.055) / 1.055) ** 2.4)


def srgb(light: Array) -> Array:
    """sRGB from 0 to 255, of linear light."""
    clipped = np.clip(light, 0.0, 1.0)
    return 255.0 * np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def vertex_normals(vertices: Array, triangles: Triangles) -> Array:
    """The unit normals (V, 3) of a surface, outwards, each the mean of its triangles' by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for k in range(3):
        for axis in range(3):
            normals[:, axis] += np.bincount(triangles[:, k], across[:, axis], len(vertices))
    unit: Array = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return unit


def lit(vertices: Array, triangles: Triangles, albedo: Array, lighting: Lighting) -> Array:
    """The colours (V, 3), BGR from 0 to 255, of a surface's vertices, by their normals; hollows are darker."""
    normals = vertex_normals(vertices, triangles)
    key = np.clip(normals @ lighting.window, -0.15, None) + 0.15  # light scatters under the skin a little way
    fill = np.clip(normals @ lighting.lamp, 0.0, None)
    sky = 0.75 + 0.25 * normals[:, 2]
    light = AMBIENT * sky + KEY * key / 1.15 + FILL * fill
    hollow = np.clip(1.0 - CAVITY * _hollowness(vertices, triangles, normals), DARKEST, 1.1)
    return srgb(albedo * (light * hollow)[:, None])


def _hollowness(vertices: Array, triangles: Triangles, normals: Array) -> Array:
    """Compute how far (V,) in m the neighbours of each vertex lie outside of its tangent plane, in the mean."""
    mean, count = np.zeros_like(vertices), np.bincount(triangles.ravel(), minlength=len(vertices))
    for one, other in ((0, 1), (1, 2), (2, 0)):
        for axis in range(3):
            mean[:, axis] += np.bincount(triangles[:, one], vertices[triangles[:, other], axis], len(vertices))
    mean /= np.maximum(count, 1)[:, None]
    hollowness: Array = np.sum((mean - vertices) * normals, axis=1)
    return hollowness
