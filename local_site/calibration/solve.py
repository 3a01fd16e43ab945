"""A rig from control points: linear cameras first, then physical ones with the least squared reprojection error."""

from collections.abc import Sequence

import numpy as np
from msgspec import convert
from numpy.typing import NDArray

from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration import accuracy, checks
from local_site.calibration.checks import likely_cause
from local_site.calibration.control_points import ControlPoints, Size, refusal
from local_site.calibration.physical_camera import PhysicalCamera, decomposed
from local_site.calibration.resection import (
    Resection,
    agreeing,
    choose_camera,
    outlier_limit,
    reprojection_errors,
    solve_projection,
    unsolvable,
)
from local_site.calibration.rig import CameraCalibration, Projection, Rig, Vector3

MANY_OUTLYING = 0.1

_Solved = tuple[Resection, str]  # a camera, and why its lens has the distortion terms it has


def solve_rig(control: ControlPoints, created: str) -> Rig:
    """The rig of a set of control points, with its residuals and leave-one-out errors.

    Raises CalibrationError, with all mistakes of all cameras together, for too few, coplanar, mirrored or grossly wrong
    points, and for cameras that were exchanged or see no common point.
    """
    mistakes: list[str] = []
    solved: list[_Solved] = []
    for name, pixels in zip(control.cameras, control.pixels, strict=True):
        outcome = _solve_camera(name, control, pixels)
        if isinstance(outcome, list):
            mistakes += outcome
        else:
            solved.append(outcome)
    resections = [resection for resection, _ in solved]
    cameras = [resection.camera for resection in resections]
    if not mistakes:
        mistakes += filter(None, [checks.same_view(cameras, control.points) or checks.exchanged(cameras)])
    if mistakes:
        raise refusal(control.source, mistakes)
    error_rms = accuracy.rms(accuracy.errors(cameras, control.points, control.pixels))
    left_out = accuracy.rms(accuracy.leave_one_out_errors(resections, control.points, control.pixels))
    rms_px = [resection.rms_px for resection in resections]
    return make_rig(control, cameras, rms_px, (error_rms, left_out), tuple(why for _, why in solved), created)


def _solve_camera(name: str, control: ControlPoints, all_pixels: Array) -> _Solved | list[str]:
    """One camera, or what is wrong with its points."""
    seen = np.isfinite(all_pixels[:, 0])
    points, pixels = control.points[seen], all_pixels[seen]
    problem = unsolvable(points) or checks.unusable(pixels)
    if problem:
        return [f"{name} camera: {problem}"]
    kept = agreeing(points, pixels)
    linear = solve_projection(points[kept], pixels[kept])
    start = decomposed(linear)
    if checks.fits_no_camera(reprojection_errors(linear, points, pixels), pixels):
        return [f"{name} camera: {likely_cause(points, pixels) or checks.NONSENSE}"]
    if start is None:
        return [f"{name} camera: {likely_cause(points, pixels) or checks.MIRRORED}"]
    return _refine(name, np.array(control.labels)[seen], (points, pixels, kept), start)


def _refine(
    name: str, labels: NDArray[np.str_], measured: tuple[Array, Array, NDArray[np.bool_]], start: PhysicalCamera
) -> _Solved | list[str]:
    """The physical camera from the linear camera's inliers, if none of all points is an outlier of it."""
    points, pixels, kept = measured
    resection, why = choose_camera(points[kept], pixels[kept], start)
    lengths = np.linalg.norm(resection.camera.pixels(points) - pixels, axis=1)
    outliers = lengths > outlier_limit(lengths[kept])
    if np.any(outliers):
        many = float(np.mean(outliers)) > MANY_OUTLYING
        cause = [f"{name} camera: {likely_cause(points, pixels) or checks.NONSENSE}"] if many else []
        return cause + [
            f"{label}: {length:.1f} px off in the {name} camera; measure this point again, or leave its pixels empty"
            for label, length in zip(labels[outliers], lengths[outliers], strict=True)
        ]
    if np.any(resection.camera.to_camera(points)[:, 2] <= 0):  # behind the camera
        return [f"{name} camera: {checks.NONSENSE}"]
    return (resection, why) if np.all(kept) else choose_camera(points, pixels, resection.camera)


def make_rig(
    control: ControlPoints,
    cameras: Sequence[PhysicalCamera],
    rms_px: Sequence[float],
    errors: tuple[Array | None, Array | None],
    lens_choice: tuple[str, ...],
    created: str,
) -> Rig:
    """The rig of fitted cameras with their residuals; `errors` (3,) in m are its 3D error and the leave-one-out error.

    Raises CalibrationError if there is no 3D error, because the views do not overlap.
    """
    error_rms, left_out = errors
    if error_rms is None:
        raise CalibrationError(f"{control.source}: no point is seen by two cameras; let their views overlap")
    return Rig(
        cameras=tuple(_calibration(*it) for it in zip(control.cameras, cameras, rms_px, control.sizes, strict=False)),
        volume_min=_vector(control.points.min(axis=0)),
        volume_max=_vector(control.points.max(axis=0)),
        error_rms=_vector(error_rms),
        created=created,
        leave_one_out_rms=None if left_out is None else _vector(left_out),
        epipolar_px=accuracy.median_epipolar_px(cameras, control.pixels),
        lens_choice=lens_choice,
    )


def _calibration(name: str, camera: PhysicalCamera, rms_px: float, size: Size | None) -> CameraCalibration:
    """The calibration of a fitted camera; an undistorted lens is left out, so that its pictures are not resampled."""
    lens = camera.lens if camera.lens.is_distorted else None
    return CameraCalibration(name, convert(camera.projection.tolist(), Projection), rms_px, lens, size_px=size)


def _vector(values: Array) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
