"""The accuracy of a calibrated rig: 3D errors at known points and on boards, also by leave-one-out."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.calibration.resection import Resection
from local_site.calibration.triangulation import epipolar_residuals, fundamentals, triangulate_many

MIN_CORNERS = 4  # with fewer, aligning the print would absorb most of the error


def triangulate_seen(cameras: Sequence[PhysicalCamera], pixels: Sequence[Array]) -> Array:
    """Points (N, 3) in m, in the frame of the cameras' poses; NaN where fewer than two cameras saw the point.

    `pixels` are each camera's distorted pixels (N, 2), NaN where it did not see the point.
    """
    undistorted = np.stack([c.lens.undistort_pixels(p) for c, p in zip(cameras, pixels, strict=True)], axis=1)
    seen = np.isfinite(undistorted[:, :, 0])
    found = np.full((len(undistorted), 3), np.nan)
    for views in np.unique(seen, axis=0):  # points seen by the same cameras are triangulated in one call
        same = np.all(seen == views, axis=1)
        if np.sum(views) >= 2:
            projections = [cameras[k].projection for k in np.flatnonzero(views).tolist()]
            found[same] = triangulate_many(projections, undistorted[same][:, views])
    return found


def errors(cameras: Sequence[PhysicalCamera], points: Array, pixels: Sequence[Array]) -> Array:
    """Triangulated minus known positions (N, 3) in m of `points` (N, 3); pixels and NaN as in `triangulate_seen`."""
    return triangulate_seen(cameras, pixels) - points


def leave_one_out_errors(resections: Sequence[Resection], points: Array, pixels: Sequence[Array]) -> Array:
    """As `errors`, with each point left out of the fit of its cameras; NaN also where the other points determine none.

    A resection counts only the points that its camera saw.
    """
    rows = [np.cumsum(np.isfinite(p[:, 0])) - 1 for p in pixels]
    found = np.full(points.shape, np.nan)
    for i in range(len(points)):
        seen = [k for k, p in enumerate(pixels) if np.isfinite(p[i, 0])]
        cameras = [resections[k].without(int(rows[k][i])) for k in seen]
        usable = [(camera, pixels[k][i : i + 1]) for camera, k in zip(cameras, seen, strict=True) if camera is not None]
        if usable:
            found[i] = triangulate_seen([camera for camera, _ in usable], [pixel for _, pixel in usable])[0]
    return found - points


def rms(values: Array) -> Array | None:
    """Root mean square (d,) of each column of (N, d), over the finite rows; None if there are none."""
    finite = values[np.all(np.isfinite(values), axis=1)]
    return np.sqrt(np.mean(finite**2, axis=0)) if len(finite) else None


def median_epipolar_px(cameras: Sequence[PhysicalCamera], pixels: Sequence[Array]) -> float | None:
    """The median epipolar residual in px of all points that the first two cameras both saw; None without any."""
    undistorted = np.stack([c.lens.undistort_pixels(p) for c, p in zip(cameras[:2], pixels[:2], strict=True)], axis=1)
    residuals = epipolar_residuals(fundamentals([camera.projection for camera in cameras[:2]]), undistorted)
    seen = residuals[np.isfinite(residuals)]
    return float(np.median(seen)) if len(seen) else None


def board_errors(
    cameras_of_pose: Sequence[Sequence[PhysicalCamera]], corners: Array, pixels_of_pose: Sequence[Sequence[Array]]
) -> Array:
    """Triangulated corners minus the print aligned with them (N, 3) in m, of all poses; frame as in `triangulate_seen`.

    `corners` (C, 3) are known on the print in m. Each pose has its own cameras and their pixels (C, 2), NaN where
    unseen; a pose with fewer than MIN_CORNERS triangulated corners is left out.
    """
    parts = [np.zeros((0, 3))]
    for cameras, pixels in zip(cameras_of_pose, pixels_of_pose, strict=True):
        found = triangulate_seen(cameras, pixels)
        known = np.isfinite(found[:, 0])
        if np.sum(known) >= MIN_CORNERS:
            parts.append(found[known] - align_rigidly(corners[known], found[known]))
    return np.concatenate(parts)


def align_rigidly(shape: Array, points: Array) -> Array:
    """A shape (N, 3) moved by the rigid motion that fits it best to points (N, 3), by least squares (Kabsch)."""
    shape_middle, points_middle = shape.mean(axis=0), points.mean(axis=0)
    u, _, vt = np.linalg.svd((shape - shape_middle).T @ (points - points_middle))
    unmirrored = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    result: Array = (shape - shape_middle) @ u @ unmirrored @ vt + points_middle
    return result
