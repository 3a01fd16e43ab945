"""Triangulation: pixels of one point in several cameras to its position, and back."""

import math
from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.kernels.compiled import compiled

MIN_DETERMINANT = 1e-12


def project(projection: Array, points: Array) -> Array:
    """Pixels (..., 2) of points (..., 3) in m by a projection (3, 4)."""
    homogeneous = points @ projection[:, :3].T + projection[:, 3]
    pixels: Array = homogeneous[..., :2] / homogeneous[..., 2:]
    return pixels


def triangulate(projections: Sequence[Array], pixels: Sequence[Array]) -> Array:
    """The point (3,) in m seen at pixels (2,) by two or more cameras: linear least squares, thesis equation 3.25."""
    return _meeting(np.array(projections), np.array(pixels, dtype=np.float64))


@compiled
def _meeting(projections: Array, pixels: Array) -> Array:
    """The point (3,) where sights of V views meet: projections (V, 3, 4), pixels (V, 2)."""
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for k in range(len(projections)):
        for d in range(2):
            row = projections[k, d] - pixels[k, d] * projections[k, 2]
            for p in range(3):
                right[p] -= row[p] * row[3]
                for q in range(3):
                    normal[p, q] += row[p] * row[q]
    if abs(np.linalg.det(normal)) < MIN_DETERMINANT * np.trace(normal) ** 3:
        return (np.linalg.pinv(normal) @ right).astype(np.float64)
    return np.linalg.solve(normal, right).astype(np.float64)


def triangulate_many(projections: Sequence[Array], pixels: Array) -> Array:
    """Points (N, 3) in m from pixels (N, V, 2) of N points in V views, as `triangulate` by the normal equations."""
    rows = np.concatenate([m[:2] - pixels[:, k, :, None] * m[2] for k, m in enumerate(projections)], axis=1)
    a, b = rows[..., :3], -rows[..., 3:]
    transposed = a.transpose(0, 2, 1)
    points: Array = np.linalg.solve(transposed @ a, transposed @ b)[..., 0]
    return points


def reprojection_residual(projections: Sequence[Array], pixels: Sequence[Array], point: Array) -> float:
    """Root mean square distance in px between the pixels (2,) and the projected point (3,)."""
    squares = [float(np.sum((project(m, point) - p) ** 2)) for m, p in zip(projections, pixels, strict=True)]
    return math.sqrt(sum(squares) / len(squares))


def fundamental_matrix(first: Array, second: Array) -> Array:
    """The F (3, 3) with second_pixel^T F first_pixel = 0, of unit norm, from two projections (3, 4)."""
    centre = np.linalg.svd(first)[2][-1]
    epipole = second @ centre
    cross = np.array([[0.0, -epipole[2], epipole[1]], [epipole[2], 0.0, -epipole[0]], [-epipole[1], epipole[0], 0.0]])
    result: Array = cross @ second @ np.linalg.pinv(first)
    return result / float(np.linalg.norm(result))


def epipolar_residual(fundamental: Array, first_pixel: Array, second_pixel: Array) -> float:
    """Sampson distance in px of a pair of pixels (2,) from satisfying the epipolar constraint."""
    a, b = np.append(first_pixel, 1.0), np.append(second_pixel, 1.0)
    line_b, line_a = fundamental @ a, fundamental.T @ b
    scale = math.sqrt(float(line_a[:2] @ line_a[:2] + line_b[:2] @ line_b[:2]))
    return abs(float(b @ line_b)) / scale if scale > 0 else math.inf


def focal_length(projection: Array) -> float:
    """The focal length in px of a projection (3, 4) whose third row gives depths in m."""
    a, b = projection[0, :3], projection[2, :3]
    dot = float(a @ b)
    return math.sqrt(max(float(a @ a) * float(b @ b) - dot * dot, 0.0))
