"""Direct linear transformation: a camera's projection from control points (thesis 3.2.9.1, equations 3.13-3.20)."""

import math

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import project

MIN_POINTS = 6
MIN_FLATNESS = 1e-3
OUTLIER_SIGMAS = 8.0
OUTLIER_PX = 2.0


def solve_projection(points: Array, pixels: Array) -> Array:
    """The projection (3, 4) of one camera from N >= 6 points (N, 3) in m, not coplanar, and their pixels (N, 2).

    The null vector of equations 3.17-3.20 after Hartley's normalisation, scaled to positive depths in m.
    """
    world_T, image_T = _normaliser(points), _normaliser(pixels)
    X = np.column_stack([points, np.ones(len(points))]) @ world_T.T
    u = (np.column_stack([pixels, np.ones(len(pixels))]) @ image_T.T)[:, :2]
    zero = np.zeros_like(X)
    rows = np.concatenate([np.hstack([X, zero, -u[:, :1] * X]), np.hstack([zero, X, -u[:, 1:] * X])])
    normalised = np.linalg.svd(rows, full_matrices=False)[2][-1].reshape(3, 4)
    projection: Array = np.linalg.inv(image_T) @ normalised @ world_T
    return _signed(projection, points)


def unsolvable(points: Array) -> str:
    """Why these points (N, 3) give no camera, with the cure; empty if they may."""
    if len(points) < MIN_POINTS:
        return f"sees {len(points)} control points, needs at least {MIN_POINTS}; show it more of the plate"
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[2] < MIN_FLATNESS * extents[0]:
        return "its control points lie in one plane; place the plate at two or more heights"
    return ""


def agreeing(points: Array, pixels: Array) -> NDArray[np.bool_]:
    """Which points (N,) a linear camera can agree on; the worst is left out first."""
    kept = np.ones(len(points), dtype=bool)
    residuals = reprojection_errors(solve_projection(points, pixels), points, pixels)
    while True:
        worst = int(np.argmax(np.where(kept, residuals, 0.0)))
        trial = kept.copy()
        trial[worst] = False
        if unsolvable(points[trial]):
            return kept
        residuals = reprojection_errors(solve_projection(points[trial], pixels[trial]), points, pixels)
        if residuals[worst] <= outlier_limit(residuals[trial]):
            return kept
        kept = trial


def outlier_limit(residuals: Array) -> float:
    """Beyond how many px a point is no longer noise, given the residuals (N,) of points that agree."""
    return max(OUTLIER_PX, OUTLIER_SIGMAS * float(np.median(residuals)))


def reprojection_errors(projection: Array, points: Array, pixels: Array) -> Array:
    """Distances (N,) in px between projected points (N, 3) and pixels (N, 2); infinite where there is no picture."""
    with np.errstate(divide="ignore", invalid="ignore"):
        distances = np.linalg.norm(project(projection, points) - pixels, axis=1)
    return np.where(np.isfinite(distances), distances, np.inf)


def _normaliser(values: Array) -> Array:
    """The similarity that takes values (N, d) to zero mean and mean distance sqrt(d)."""
    dimension = values.shape[1]
    centre = values.mean(axis=0)
    distance = float(np.linalg.norm(values - centre, axis=1).mean())
    scale = math.sqrt(dimension) / max(distance, 1e-12)
    result = np.diag([*[scale] * dimension, 1.0])
    result[:dimension, dimension] = -scale * centre
    return result


def _signed(projection: Array, points: Array) -> Array:
    """The same projection, scaled so that depths of the points come out positive and in m."""
    depth = float(np.mean(points @ projection[2, :3] + projection[2, 3]))
    scale = math.copysign(max(float(np.linalg.norm(projection[2, :3])), 1e-300), depth)
    return projection / scale
