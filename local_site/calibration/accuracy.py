"""How well a rig gives known points back: by the cameras that saw them all, and by cameras made without each."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.calibration.resection import Resection
from local_site.calibration.triangulation import epipolar_residual, fundamental_matrix, triangulate_many


def located(cameras: Sequence[PhysicalCamera], pixels: Sequence[Array]) -> Array:
    """Points (N, 3) in m from each camera's pixels (N, 2), NaN where unseen; NaN where fewer than two saw them."""
    straight = np.stack([c.lens.undistort_pixels(p) for c, p in zip(cameras, pixels, strict=True)], axis=1)
    seen = np.isfinite(straight[:, :, 0])
    found = np.full((len(straight), 3), np.nan)
    for views in np.unique(seen, axis=0):
        mine = np.all(seen == views, axis=1)
        if np.sum(views) >= 2:
            projections = [cameras[k].projection for k in np.flatnonzero(views).tolist()]
            found[mine] = triangulate_many(projections, straight[mine][:, views])
    return found


def errors(cameras: Sequence[PhysicalCamera], points: Array, pixels: Sequence[Array]) -> Array:
    """Located less known position (N, 3) of points (N, 3), m; NaN where fewer than two cameras saw it."""
    return located(cameras, pixels) - points


def leave_one_out_errors(resections: Sequence[Resection], points: Array, pixels: Sequence[Array]) -> Array:
    """As `errors`, each point by cameras fitted without it; NaN too where the rest would not give a camera."""
    places = [np.cumsum(np.isfinite(p[:, 0])) - 1 for p in pixels]
    found = np.full(points.shape, np.nan)
    for i in range(len(points)):
        seen = [k for k, p in enumerate(pixels) if np.isfinite(p[i, 0])]
        cameras = [resections[k].without(int(places[k][i])) for k in seen]
        usable = [(camera, pixels[k][i : i + 1]) for camera, k in zip(cameras, seen, strict=True) if camera is not None]
        if usable:
            found[i] = located([camera for camera, _ in usable], [pixel for _, pixel in usable])[0]
    return found - points


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
