"""Direct linear transformation: a rig from control points, refined on the reprojection error (thesis 3.2.9.1)."""

import math

import numpy as np
from numpy.typing import NDArray

from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration.control_points import CAMERAS, ControlPoints, refusal
from local_site.calibration.rig import CameraCalibration, Rig, Row4
from local_site.calibration.triangulation import project, triangulate

MIN_POINTS = 6
MIN_FLATNESS = 1e-3
OUTLIER_SIGMAS = 8.0
OUTLIER_PX = 2.0
REFINEMENTS = 10


def solve_rig(control: ControlPoints, created: str) -> Rig:
    """The rig of a set of control points, with rms reprojection per camera and 3D error per axis.

    Raises CalibrationError, with all mistakes of all cameras at once, for too few, coplanar or grossly wrong points.
    """
    mistakes: list[str] = []
    projections = []
    for name, pixels in zip(CAMERAS, control.pixels, strict=True):
        seen = np.isfinite(pixels[:, 0])
        problem = _unsolvable(control.points[seen])
        if problem:
            mistakes.append(f"{name} camera: {problem}")
            continue
        projection, outliers = _fit_without_outliers(control.points[seen], pixels[seen])
        residuals = _residuals(projection, control.points, pixels)
        mistakes += [_outlier(control.lines[i], name, residuals[i]) for i in np.flatnonzero(seen)[outliers]]
        projections.append(projection)
    if mistakes:
        raise refusal(control.source, mistakes)
    return _rig(control, projections, created)


def solve_projection(points: Array, pixels: Array) -> Array:
    """The projection (3, 4) of one camera from N >= 6 points (N, 3) in m, not coplanar, and their pixels (N, 2)."""
    return _refined(_linear(points, pixels), points, pixels)


def _unsolvable(points: Array) -> str:
    if len(points) < MIN_POINTS:
        return f"sees {len(points)} control points, needs at least {MIN_POINTS}; show it more of the plate"
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[2] < MIN_FLATNESS * extents[0]:
        return "its control points lie in one plane; place the plate at two or more heights"
    return ""


def _outlier(line: int, camera: str, residual: float) -> str:
    cure = "measure this point again, or leave its pixels empty"
    return f"line {line}: {residual:.1f} px off in the {camera} camera; {cure}"


def _fit_without_outliers(points: Array, pixels: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The projection from the points that agree, and which points do not; the worst is left out first."""
    kept = np.ones(len(points), dtype=bool)
    projection = solve_projection(points, pixels)
    while True:
        residuals = _residuals(projection, points, pixels)
        limit = max(OUTLIER_PX, OUTLIER_SIGMAS * float(np.median(residuals[kept])))
        worst = int(np.argmax(np.where(kept, residuals, 0.0)))
        trial = kept.copy()
        trial[worst] = False
        if _unsolvable(points[trial]):
            return projection, residuals > limit
        without = solve_projection(points[trial], pixels[trial])
        rest = _residuals(without, points, pixels)
        limit = max(OUTLIER_PX, OUTLIER_SIGMAS * float(np.median(rest[trial])))
        if rest[worst] <= limit:
            return projection, ~kept
        kept, projection = trial, without


def _linear(points: Array, pixels: Array) -> Array:
    """Hartley-normalised DLT: the null vector of equations 3.17-3.20."""
    world_T, image_T = _normaliser(points), _normaliser(pixels)
    X = np.column_stack([points, np.ones(len(points))]) @ world_T.T
    u = (np.column_stack([pixels, np.ones(len(pixels))]) @ image_T.T)[:, :2]
    zero = np.zeros_like(X)
    rows = np.concatenate([np.hstack([X, zero, -u[:, :1] * X]), np.hstack([zero, X, -u[:, 1:] * X])])
    normalised = np.linalg.svd(rows)[2][-1].reshape(3, 4)
    projection: Array = np.linalg.inv(image_T) @ normalised @ world_T
    return _signed(projection, points)


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
    scale = math.copysign(float(np.linalg.norm(projection[2, :3])), depth)
    return projection / scale


def _refined(projection: Array, points: Array, pixels: Array) -> Array:
    """Gauss-Newton on the reprojection error over all twelve numbers; the free scale is left to the minimum norm."""
    X = np.column_stack([points, np.ones(len(points))])
    zero = np.zeros_like(X)
    best, best_error = projection, float(np.sum(_residuals(projection, points, pixels) ** 2))
    for _ in range(REFINEMENTS):
        w = X @ best[2]
        Xw = X / w[:, None]
        u = (X @ best[:2].T) / w[:, None]
        rows = np.concatenate([np.hstack([Xw, zero, -u[:, :1] * Xw]), np.hstack([zero, Xw, -u[:, 1:] * Xw])])
        step = np.linalg.lstsq(rows, np.concatenate([pixels[:, 0] - u[:, 0], pixels[:, 1] - u[:, 1]]), rcond=1e-12)[0]
        trial = best + step.reshape(3, 4)
        error = float(np.sum(_residuals(trial, points, pixels) ** 2))
        if not error < best_error:
            break
        best, best_error = trial, error
    return _signed(best, points)


def _residuals(projection: Array, points: Array, pixels: Array) -> Array:
    distances: Array = np.linalg.norm(project(projection, points) - pixels, axis=1)
    return distances


def _rig(control: ControlPoints, projections: list[Array], created: str) -> Rig:
    both = np.flatnonzero(np.all([np.isfinite(pixels[:, 0]) for pixels in control.pixels], axis=0))
    if not len(both):
        raise CalibrationError(f"{control.source}: no point is seen by both cameras; let their views overlap")
    errors = [triangulate(projections, [p[i] for p in control.pixels]) - control.points[i] for i in both]
    error_rms = np.sqrt(np.mean(np.square(errors), axis=0))
    cameras = [_camera(*it, control.points) for it in zip(CAMERAS, projections, control.pixels, strict=True)]
    return Rig(
        cameras=tuple(cameras),
        volume_min=_vector(control.points.min(axis=0)),
        volume_max=_vector(control.points.max(axis=0)),
        error_rms=_vector(error_rms),
        created=created,
    )


def _camera(name: str, projection: Array, pixels: Array, points: Array) -> CameraCalibration:
    residuals = _residuals(projection, points, pixels)
    rms = math.sqrt(float(np.nanmean(residuals**2)))
    rows = [_row(row) for row in projection]
    return CameraCalibration(name=name, projection=(rows[0], rows[1], rows[2]), reprojection_rms_px=rms)


def _row(row: Array) -> Row4:
    a, b, c, d = (float(value) for value in row)
    return a, b, c, d


def _vector(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z
