"""How well a rig gives known points back: by the cameras that saw them all, and by cameras made without each."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.calibration.resection import Resection
from local_site.calibration.triangulation import epipolar_residual, fundamental_matrix, triangulate


def located(cameras: Sequence[PhysicalCamera | None], pixels: Sequence[Array]) -> Array:
    """The point (3,) in m from its pixels (2,) in each camera's picture, NaN where unseen; NaN if fewer than two."""
    views = [(c, p) for c, p in zip(cameras, pixels, strict=True) if c is not None and np.isfinite(p[0])]
    if len(views) < 2:
        return np.full(3, np.nan)
    return triangulate([c.projection for c, _ in views], [c.lens.undistort_pixels(p) for c, p in views])


def errors(cameras: Sequence[PhysicalCamera], points: Array, pixels: Sequence[Array]) -> Array:
    """Located less known position (N, 3) of points (N, 3), m; NaN where fewer than two cameras saw it."""
    return np.array([located(cameras, [p[i] for p in pixels]) for i in range(len(points))]) - points


def leave_one_out_errors(resections: Sequence[Resection], points: Array, pixels: Sequence[Array]) -> Array:
    """As `errors`, each point by cameras fitted without it; NaN too where the rest would not give a camera."""
    places = [np.cumsum(np.isfinite(p[:, 0])) - 1 for p in pixels]
    found = []
    for i in range(len(points)):
        seen = [p[i] for p in pixels]
        cameras = [
            r.without(int(place[i])) if np.isfinite(p[0]) else None
            for r, place, p in zip(resections, places, seen, strict=True)
        ]
        found.append(located(cameras, seen))
    return np.array(found) - points


def rms(values: Array) -> Array | None:
    """Root mean square per column of the finite rows of (N, d); None if there are none."""
    finite = values[np.all(np.isfinite(values), axis=1)]
    return np.sqrt(np.mean(finite**2, axis=0)) if len(finite) else None


def epipolar_residuals(cameras: Sequence[PhysicalCamera], pixels: Sequence[Array]) -> Array:
    """Epipolar residuals (M,) in px of all points that the first two cameras both saw."""
    fundamental = fundamental_matrix(cameras[0].projection, cameras[1].projection)
    first, second = (c.lens.undistort_pixels(p) for c, p in zip(cameras[:2], pixels[:2], strict=True))
    pairs = zip(first, second, strict=True)
    values = [epipolar_residual(fundamental, a, b) for a, b in pairs if np.isfinite(a[0]) and np.isfinite(b[0])]
    return np.array(values)
