"""A rig from control points: linear cameras first, then physical ones with the least squared reprojection error."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration import accuracy, checks
from local_site.calibration.control_points import ControlPoints, Size, refusal
from local_site.calibration.dlt import agreeing, outlier_limit, reprojection_errors, solve_projection, unsolvable
from local_site.calibration.likely_cause import likely_cause
from local_site.calibration.physical_camera import PhysicalCamera, decomposed
from local_site.calibration.resection import Resection, choose_camera
from local_site.calibration.rig import CameraCalibration, Rig, Row4, Vector3

MANY_OUTLYING = 0.1


@dataclass(frozen=True, slots=True)
class _Solved:
    resection: Resection
    why: str


def solve_rig(control: ControlPoints, created: str) -> Rig:
    """The rig of a set of control points, with its residuals, and its leave-one-out residuals.

    Raises CalibrationError, with all mistakes of all cameras at once, for too few, coplanar, mirrored or grossly wrong
    points, and for cameras that were exchanged or have nothing in common.
    """
    mistakes: list[str] = []
    solved: list[_Solved] = []
    for name, pixels in zip(control.cameras, control.pixels, strict=True):
        outcome = _solve_camera(name, control, pixels)
        if isinstance(outcome, _Solved):
            solved.append(outcome)
        else:
            mistakes += outcome
    if not mistakes:
        cameras = [one.resection.camera for one in solved]
        mistakes += filter(None, [checks.same_view(cameras, control.points) or checks.exchanged(cameras)])
    if mistakes:
        raise refusal(control.source, mistakes)
    return _rig(control, solved, created)


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
    """The physical camera from the points that a linear one agrees on, if all points agree with it."""
    points, pixels, kept = measured
    resection, why = choose_camera(points[kept], pixels[kept], start)
    lengths = np.linalg.norm(resection.camera.pixels(points) - pixels, axis=1)
    outliers = lengths > outlier_limit(lengths[kept])
    if np.any(outliers):
        many = float(np.mean(outliers)) > MANY_OUTLYING
        cause = [f"{name} camera: {likely_cause(points, pixels) or checks.NONSENSE}"] if many else []
        return cause + _outliers(name, labels[outliers], lengths[outliers])
    if checks.looks_backwards(resection.camera, points):
        return [f"{name} camera: {checks.NONSENSE}"]
    return _Solved(*((resection, why) if np.all(kept) else choose_camera(points, pixels, resection.camera)))


def _outliers(camera: str, labels: NDArray[np.str_], lengths: Array) -> list[str]:
    cure = "measure this point again, or leave its pixels empty"
    return [
        f"{label}: {length:.1f} px off in the {camera} camera; {cure}"
        for label, length in zip(labels, lengths, strict=True)
    ]


def _rig(control: ControlPoints, solved: list[_Solved], created: str) -> Rig:
    resections = [one.resection for one in solved]
    cameras = [resection.camera for resection in resections]
    error_rms = accuracy.rms(accuracy.errors(cameras, control.points, control.pixels))
    if error_rms is None:
        raise CalibrationError(f"{control.source}: no point is seen by two cameras; let their views overlap")
    without = accuracy.rms(accuracy.leave_one_out_errors(resections, control.points, control.pixels))
    return Rig(
        cameras=tuple(
            camera_calibration(name, resection.camera, resection.rms_px, size)
            for name, resection, size in zip(control.cameras, resections, control.sizes, strict=False)
        ),
        volume_min=vector(control.points.min(axis=0)),
        volume_max=vector(control.points.max(axis=0)),
        error_rms=vector(error_rms),
        created=created,
        leave_one_out_rms=None if without is None else vector(without),
        epipolar_px=accuracy.median_epipolar_px(cameras, control.pixels),
        lens_choice=tuple(one.why for one in solved),
    )


def camera_calibration(name: str, camera: PhysicalCamera, rms_px: float, size: Size | None) -> CameraCalibration:
    """What the rig keeps of a fitted camera; a straight lens is not kept, so that nobody straightens for nothing."""
    rows = [_row(row) for row in camera.projection]
    return CameraCalibration(
        name=name,
        projection=(rows[0], rows[1], rows[2]),
        reprojection_rms_px=rms_px,
        lens=camera.lens if camera.lens.is_distorted else None,
        size_px=size,
    )


def vector(values: Array) -> Vector3:
    """Three numbers for a rig file."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def _row(row: Array) -> Row4:
    a, b, c, d = (float(value) for value in row)
    return a, b, c, d
