"""The 3D errors of a rig at known points and boards, also with each point left out of the calibration in turn."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.calibration.resection import Resection
from local_site.calibration.triangulation import epipolar_residuals, fundamentals, triangulate_many


def located(cameras: Sequence[PhysicalCamera], pixels: Sequence[Array]) -> Array:
    """Points (N, 3) in m from each camera's pixels (N, 2), NaN where unseen; NaN where fewer than two saw them."""
    undistorted = np.stack([c.lens.undistort_pixels(p) for c, p in zip(cameras, pixels, strict=True)], axis=1)
    seen = np.isfinite(undistorted[:, :, 0])
    found = np.full((len(undistorted), 3), np.nan)
    for views in np.unique(seen, axis=0):
        mine = np.all(seen == views, axis=1)
        if np.sum(views) >= 2:
            projections = [cameras[k].projection for k in np.flatnonzero(views).tolist()]
            found[mine] = triangulate_many(projections, undistorted[mine][:, views])
    return found


def errors(cameras: Sequence[PhysicalCamera], points: Array, pixels: Sequence[Array]) -> Array:
    """Located less known position (N, 3) of points (N, 3), m; NaN where fewer than two cameras saw it."""
    return located(cameras, pixels) - points


def leave_one_out_errors(resections: Sequence[Resection], points: Array, pixels: Sequence[Array]) -> Array:
    """As `errors`, each point by cameras fitted without it; NaN too where the rest would not give a camera."""
    ranks = [np.cumsum(np.isfinite(p[:, 0])) - 1 for p in pixels]
    found = np.full(points.shape, np.nan)
    for i in range(len(points)):
        seen = [k for k, p in enumerate(pixels) if np.isfinite(p[i, 0])]
        cameras = [resections[k].without(int(ranks[k][i])) for k in seen]
        usable = [(camera, pixels[k][i : i + 1]) for camera, k in zip(cameras, seen, strict=True) if camera is not None]
        if usable:
            found[i] = located([camera for camera, _ in usable], [pixel for _, pixel in usable])[0]
    return found - points


def rms(values: Array) -> Array | None:
    """Root mean square per column of the finite rows of (N, d); None if there are none."""
    finite = values[np.all(np.isfinite(values), axis=1)]
    return np.sqrt(np.mean(finite**2, axis=0)) if len(finite) else None


def median_epipolar_px(cameras: Sequence[PhysicalCamera], pixels: Sequence[Array]) -> float | None:
    """The median epipolar residual in px of all points that the first two cameras both saw; None without any."""
    undistorted = np.stack([c.lens.undistort_pixels(p) for c, p in zip(cameras[:2], pixels[:2], strict=True)], axis=1)
    residuals = epipolar_residuals(fundamentals([camera.projection for camera in cameras[:2]]), undistorted)
    seen = residuals[np.isfinite(residuals)]
    return float(np.median(seen)) if len(seen) else None


MIN_CORNERS = 4


def board_errors(
    cameras_of_pose: Sequence[Sequence[PhysicalCamera]], corners: Array, pixels_of_pose: Sequence[Sequence[Array]]
) -> Array:
    """Located corners less the print laid upon them (N, 3), m, in the cameras' frame.

    Corners (C, 3) on the print in m; for each pose its cameras, and each camera's pixels (C, 2), NaN where unseen.
    """
    parts = [np.zeros((0, 3))]
    for cameras, pixels in zip(cameras_of_pose, pixels_of_pose, strict=True):
        found = located(cameras, pixels)
        known = np.isfinite(found[:, 0])
        if np.sum(known) >= MIN_CORNERS:
            parts.append(found[known] - laid_upon(corners[known], found[known]))
    return np.concatenate(parts)


def laid_upon(shape: Array, points: Array) -> Array:
    """A shape (N, 3) moved rigidly onto points (N, 3) with the least squared distances (Kabsch)."""
    shape_middle, points_middle = shape.mean(axis=0), points.mean(axis=0)
    u, _, vt = np.linalg.svd((shape - shape_middle).T @ (points - points_middle))
    proper = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    result: Array = (shape - shape_middle) @ u @ proper @ vt + points_middle
    return result
