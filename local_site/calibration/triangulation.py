"""Projection and triangulation: points to pixels with Jacobians, pixels to points, and epipolar geometry."""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from common.geometry import Array, skew
from local_site.kernels.compiled import compiled

MIN_DETERMINANT = 1e-12

Pair = tuple[int, int]


def project(projection: Array, points: Array) -> Array:
    """Pixels (..., 2) of points (..., 3) in m by a projection (3, 4)."""
    homogeneous = points @ projection[:, :3].T + projection[:, 3]
    return homogeneous[..., :2] / homogeneous[..., 2:]


@compiled
def image_of(projection: Array, point: Array) -> tuple[Array, Array, float]:
    """The pixel (2,) of a point (3,) in m by a projection (3, 4), its Jacobian (2, 3) in px per m, the depth in m."""
    h = projection[:, 3].copy()
    for d in range(3):
        h += projection[:, d] * point[d]
    pixel, jacobian = h[:2] / h[2], np.empty((2, 3))
    for d in range(2):
        jacobian[d] = (projection[d, :3] - pixel[d] * projection[2, :3]) / h[2]
    return pixel, jacobian, h[2]


def images_of(projections: Array, point: Array) -> tuple[Array, Array]:
    """As `image_of` in V views (V, 3, 4): pixels (V, 2) and Jacobians (V, 2, 3)."""
    homogeneous = projections[:, :, :3] @ point + projections[:, :, 3]
    pixels = homogeneous[:, :2] / homogeneous[:, 2:]
    jacobians = projections[:, :2, :3] - pixels[..., None] * projections[:, 2:, :3]
    return pixels, jacobians / homogeneous[:, 2:, None]


def triangulate(projections: Sequence[Array], pixels: Sequence[Array]) -> Array:
    """The point (3,) in m seen at pixels (2,) by two or more cameras: linear least squares, thesis equation 3.25."""
    return _meeting(np.array(projections), np.array(pixels, dtype=np.float64))


@compiled
def _meeting(projections: Array, pixels: Array) -> Array:
    """The point (3,) nearest to the lines of sight of V views: projections (V, 3, 4), pixels (V, 2)."""
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
    return np.linalg.solve(transposed @ a, transposed @ b)[..., 0]


def reprojection_residual(projections: Sequence[Array], pixels: Sequence[Array], point: Array) -> float:
    """Root mean square distance in px between the pixels (2,) and the projected point (3,)."""
    squares = [float(np.sum((project(m, point) - p) ** 2)) for m, p in zip(projections, pixels, strict=True)]
    return math.sqrt(sum(squares) / len(squares))


def fundamental_matrix(first: Array, second: Array) -> Array:
    """The F (3, 3) with second_pixel^T F first_pixel = 0, of unit norm, from two projections (3, 4)."""
    centre = np.linalg.svd(first)[2][-1]
    epipole = second @ centre
    result: Array = skew(epipole) @ second @ np.linalg.pinv(first)
    return result / float(np.linalg.norm(result))


def fundamentals(projections: Sequence[Array]) -> dict[Pair, Array]:
    """The fundamental matrix (3, 3) of every pair of views, from their projections (3, 4)."""
    return {
        (i, j): fundamental_matrix(projections[i], projections[j]) for i, j in combinations(range(len(projections)), 2)
    }


def epipolar_residuals(of_pairs: Mapping[Pair, Array], pixels: Array) -> Array:
    """Epipolar residuals (N, pairs) in px of N points in V views, undistorted pixels (N, V, 2); NaN where unseen.

    The Sampson distance, for every pair of `fundamentals`.
    """
    homogeneous = np.concatenate([pixels, np.ones((*pixels.shape[:2], 1))], axis=2)
    columns = []
    for (i, j), fundamental in of_pairs.items():
        lines_j, lines_i = homogeneous[:, i] @ fundamental.T, homogeneous[:, j] @ fundamental
        scale = np.sqrt(np.sum(lines_i[:, :2] ** 2, axis=1) + np.sum(lines_j[:, :2] ** 2, axis=1))
        columns.append(np.abs(np.sum(homogeneous[:, j] * lines_j, axis=1)) / np.maximum(scale, 1e-300))
    return np.column_stack(columns)


def focal_length(projection: Array) -> float:
    """The focal length in px of a projection (3, 4) whose third row gives depths in m."""
    a, b = projection[0, :3], projection[2, :3]
    dot = float(a @ b)
    return math.sqrt(max(float(a @ a) * float(b @ b) - dot * dot, 0.0))
