"""Checks of solved cameras: mirrored pictures, exchanged cameras, points that no camera could have seen."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera

MAX_RELATIVE_RESIDUAL = 0.02
MIN_AGREEING = 2 / 3
MIN_SPREAD = 1e-6
MIN_SIDEWAYS = 0.3
MIN_TURNED = 0.3
MIN_PARALLAX = 0.02

MIRRORED = (
    "sees the points mirrored; switch off the mirroring of its picture, or correct the axes of the control points "
    "(x right, y away, z up)"
)
NONSENSE = (
    "its pixels fit no camera that could see these points; make sure that each line holds one point's position in mm "
    "and its own pixels, left camera first"
)
SAME_VIEW = (
    "both cameras see the points from one direction, so that depth cannot be told; make sure that each camera's "
    "pictures are its own, and move the cameras apart"
)
EXCHANGED = (
    "the left camera stands to the right of the right one, as both see it; exchange the two, or switch off the "
    "mirroring of both pictures"
)

UPSIDE_DOWN = (
    "stands upside down: turn it, or its picture, by 180 degrees and calibrate again, unless it hangs so on purpose"
)
TURNED_AXES = (
    "sees X_mm run to the left, so that the hand would move the robot the wrong way: give the control points with x to "
    "the right as the cameras see it, y away and z up, or adapt mapping.base_R_operator"
)


def unusable(pixels: Array) -> str:
    """Why these pixels (N, 2) give no camera, with the cure; empty if they may."""
    spread = np.linalg.svd(pixels - pixels.mean(axis=0), compute_uv=False)
    return NONSENSE if spread[0] == 0.0 or spread[1] < MIN_SPREAD * spread[0] else ""


def fits_no_camera(residuals: Array, pixels: Array) -> bool:
    """Whether too many of the residuals (N,) of pixels (N, 2) are too large for a camera, its lens and its noise."""
    extent = float(np.linalg.norm(np.ptp(pixels, axis=0)))
    return float(np.quantile(residuals, MIN_AGREEING)) > MAX_RELATIVE_RESIDUAL * extent


def same_view(cameras: Sequence[PhysicalCamera], points: Array) -> str:
    """What to do if the first two cameras see the points (N, 3) from one direction; empty if all is well."""
    rays = [np.median(points, axis=0) - camera.centre for camera in cameras[:2]]
    first, second = (ray / max(float(np.linalg.norm(ray)), 1e-12) for ray in rays)
    return SAME_VIEW if float(np.linalg.norm(np.cross(first, second))) < MIN_PARALLAX else ""


def looks_backwards(camera: PhysicalCamera, points: Array) -> bool:
    """Whether a point (N, 3) lies behind the camera that is said to see it."""
    return bool(np.any(camera.to_camera(points)[:, 2] <= 0))


def upside_down(camera: PhysicalCamera) -> bool:
    """Whether what is below in the camera's picture lies above in the operator frame."""
    return float(camera.camera_R_operator[1, 2]) > MIN_TURNED


def odd_stance(camera: PhysicalCamera) -> str:
    """What to do about a camera that fits, but stands as few do; empty if all is well."""
    if upside_down(camera):
        return UPSIDE_DOWN
    return TURNED_AXES if float(camera.camera_R_operator[0, 0]) < -MIN_TURNED else ""


def exchanged(cameras: Sequence[PhysicalCamera]) -> str:
    """What to do if the left camera stands to the right of the right one, as both see it; empty if all is well."""
    left, right = cameras[:2]
    baseline = right.centre - left.centre
    sideways = baseline / max(float(np.linalg.norm(baseline)), 1e-12)
    to_the_right = [camera.camera_R_operator[0] * (-1.0 if upside_down(camera) else 1.0) for camera in (left, right)]
    return EXCHANGED if all(float(axis @ sideways) < -MIN_SIDEWAYS for axis in to_the_right) else ""
