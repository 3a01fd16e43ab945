"""Checks of solved cameras and of rigs from files, and the most likely mistake in control points that fit no camera."""

from collections.abc import Iterator, Sequence
from itertools import permutations

import numpy as np

from common.geometry import Array
from local_site.calibration.control_points import CAMERAS
from local_site.calibration.physical_camera import PhysicalCamera, decomposed
from local_site.calibration.resection import reprojection_errors, solve_projection
from local_site.calibration.rig import CameraCalibration, Rig

MAX_RELATIVE_RESIDUAL = 0.02
MIN_AGREEING = 2 / 3
MIN_SPREAD = 1e-6
MIN_SIDEWAYS = 0.3
MIN_TURNED = 0.3
MIN_OVERTURNED = 0.7
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
    "both cameras see the points from one direction, so that depth cannot be measured; make sure that each camera's "
    "pictures are its own, and move the cameras apart"
)
EXCHANGED = (
    "the left camera is to the right of the right one, as both see it; exchange the two, or switch off the "
    "mirroring of both pictures"
)

UPSIDE_DOWN = (
    "is upside down: turn it, or its picture, by 180 degrees and calibrate again, unless it hangs so on purpose; "
    "with a printed board, lay it level in the first pose"
)
TURNED_AXES = (
    "sees X_mm run to the left, so that the robot would move against the hand: give the control points with x to "
    "the right as the cameras see it, y away and z up, or adapt mapping.base_R_operator"
)


def unusable(pixels: Array) -> str:
    """Say why these pixels (N, 2) give no camera, with the cure; empty if they may."""
    spread = np.linalg.svd(pixels - pixels.mean(axis=0), compute_uv=False)
    return NONSENSE if spread[0] == 0.0 or spread[1] < MIN_SPREAD * spread[0] else ""


def fits_no_camera(residuals: Array, pixels: Array) -> bool:
    """Return whether too many residuals (N,) of pixels (N, 2) are too large for a camera, its lens and its noise."""
    extent = float(np.linalg.norm(np.ptp(pixels, axis=0)))
    return float(np.quantile(residuals, MIN_AGREEING)) > MAX_RELATIVE_RESIDUAL * extent


def same_view(cameras: Sequence[PhysicalCamera], points: Array) -> str:
    """Say what to do if the first two cameras see the points (N, 3) from one direction; empty if all is well."""
    rays = [np.median(points, axis=0) - camera.centre for camera in cameras[:2]]
    first, second = (ray / max(float(np.linalg.norm(ray)), 1e-12) for ray in rays)
    return SAME_VIEW if float(np.linalg.norm(np.cross(first, second))) < MIN_PARALLAX else ""


def upside_down(camera: PhysicalCamera) -> bool:
    """Return whether what is below in the camera's picture lies above in the operator frame."""
    # A camera that faces a tilted first board looks past the vertical of its frame, and is not upside down.
    return rolled_over(camera) or float(camera.camera_R_operator[1, 2]) > MIN_OVERTURNED


def rolled_over(camera: PhysicalCamera) -> bool:
    """Return whether both axes of the camera's picture run the other way in the operator frame."""
    right, down, _ = camera.camera_R_operator
    return float(down[2]) > MIN_TURNED and float(right[0]) < 0


def odd_orientation(camera: PhysicalCamera) -> str:
    """Say what to do about a camera with an unusual orientation; empty if all is well."""
    if upside_down(camera):
        return UPSIDE_DOWN
    return TURNED_AXES if float(camera.camera_R_operator[0, 0]) < -MIN_TURNED else ""


def exchanged(cameras: Sequence[PhysicalCamera]) -> str:
    """Say what to do if the left camera is to the right of the right one, as both see it; empty if all is well."""
    left, right = cameras[:2]
    baseline = right.centre - left.centre
    sideways = baseline / max(float(np.linalg.norm(baseline)), 1e-12)
    to_the_right = [camera.camera_R_operator[0] * (-1.0 if rolled_over(camera) else 1.0) for camera in (left, right)]
    return EXCHANGED if all(float(axis @ sideways) < -MIN_SIDEWAYS for axis in to_the_right) else ""


MAX_SKEW = 0.05
MAX_ASPECT = 1.4
MAX_DISTORTION = 2.0
MIN_DETERMINANT = 1e-12
ASIDE = 1.0  # how far beside the picture, in widths and heights of it, the middle of the volume may lie


def rig_mistakes(rig: Rig) -> list[str]:
    """Everything that cannot be right in a rig, a sentence each; empty if all is well."""
    names = tuple(camera.name for camera in rig.cameras)
    expected = CAMERAS[: len(names)]
    if len(names) < 2 or names != expected:
        found = ", ".join(names) or "none"
        return [
            f"its cameras are {found}, but must be left, right and, if there are more, third, fourth, in this order"
        ]
    if any(low >= high for low, high in zip(rig.volume_min, rig.volume_max, strict=True)):
        return ["the box of its control points, volume_min to volume_max, has no size"]
    middle = (np.array(rig.volume_min) + np.array(rig.volume_max)) / 2
    mistakes = [f"{camera.name} camera: {what}" for camera in rig.cameras for what in _camera_mistakes(camera, middle)]
    if mistakes:
        return mistakes
    cameras = [camera for one in rig.cameras if (camera := decomposed(_facing(one.matrix, middle))) is not None]
    return [what for what in (same_view(cameras, middle[None]) or exchanged(cameras),) if what]


def _camera_mistakes(calibrated: CameraCalibration, middle: Array) -> Iterator[str]:
    """Say what is wrong with one camera, given the middle (3,) of the volume, m."""
    matrix = _facing(calibrated.matrix, middle)
    if abs(float(np.linalg.det(matrix[:, :3]))) < MIN_DETERMINANT:
        yield "its projection is singular"
        return
    camera = decomposed(matrix)
    if camera is None:
        yield "its projection is mirrored, or looks away from the volume"
        return
    if not _is_a_cameras(matrix, camera):
        yield "its projection is not that of a camera: its pixels are not nearly square"
    width, height = calibrated.size_px or (2 * camera.lens.cx, 2 * camera.lens.cy)
    pixel = camera.pixels(middle)
    if not np.all(np.abs(pixel / (width, height) - 0.5) <= 0.5 + ASIDE):
        yield "it does not see the middle of the volume"
    lens = calibrated.lens
    if lens is not None:
        inner = height / 4
        distorted = float(lens.distort_pixels(np.array([lens.cx + inner, lens.cy]))[0] - lens.cx) / inner
        if not 1 / MAX_DISTORTION < distorted < MAX_DISTORTION:
            yield "its lens distorts the picture implausibly"


def _facing(matrix: Array, middle: Array) -> Array:
    """The projection (3, 4) with the sign that gives the middle of the volume a positive depth."""
    depth = float(matrix[2, :3] @ middle + matrix[2, 3])
    return -matrix if depth < 0 else matrix


def _is_a_cameras(matrix: Array, camera: PhysicalCamera) -> bool:
    """Return whether the projection is nearly that of square pixels in rows and columns."""
    lens = camera.lens
    calibration = matrix[:, :3] @ camera.camera_R_operator.T
    skew = float(calibration[0, 1] / calibration[0, 0])
    return abs(skew) < MAX_SKEW and 1 / MAX_ASPECT < lens.fx / lens.fy < MAX_ASPECT


MAX_HEIGHTS = 4
MIN_TO_THE_RIGHT = 0.5
MIN_AWAY = -0.3
AXES = "correct the axes of the control points (x right, y away, z up)"

_Repair = tuple[str, Array, Array]  # a mistake in words, with points (N, 3) in m and pixels (N, 2) as without it


def likely_cause(points: Array, pixels: Array) -> str:
    """The one mistake, with its cure, without which points (N, 3) in m and pixels (N, 2) fit a camera; empty if none.

    Mirrored pictures, exchanged axes and heights in the wrong order can fit equally well; they are distinguished by
    the camera's usual orientation: x to its right, y away from it, and rather above the points than below.
    """
    found: list[tuple[bool, float, str]] = []
    for mistake, true_points, true_pixels in _repairs(points, pixels):
        projection = solve_projection(true_points, true_pixels)
        residuals = reprojection_errors(projection, true_points, true_pixels)
        camera = decomposed(projection)
        if camera is not None and _is_on_the_right(camera) and not fits_no_camera(residuals, true_pixels):
            below = bool(camera.centre[2] < true_points[:, 2].mean())
            found.append((below, round(float(np.median(residuals)), 3), mistake))
    return min(found)[2] if found else ""


def _is_on_the_right(camera: PhysicalCamera) -> bool:
    to_the_right, _, ahead = camera.camera_R_operator
    return float(to_the_right[0]) > MIN_TO_THE_RIGHT and float(ahead[1]) > MIN_AWAY


def _repairs(points: Array, pixels: Array) -> Iterator[_Repair]:
    mirrored = f"sees the points mirrored; switch off the mirroring of its picture or, if X_mm runs to the left, {AXES}"
    yield (mirrored, points, pixels * (-1.0, 1.0))
    yield ("sees the points upside down and mirrored; count v from the top", points, pixels * (1.0, -1.0))
    yield ("its u and v are exchanged; give u along the rows first", points, pixels[:, ::-1])
    towards = f"sees the points mirrored, as if Y_mm ran towards the cameras; {AXES}"
    yield (towards, points * (1.0, -1.0, 1.0), pixels)
    yield (f"sees the points mirrored, as if X_mm and Y_mm were exchanged; {AXES}", points[:, [1, 0, 2]], pixels)
    yield from _other_heights(points, pixels)


def _other_heights(points: Array, pixels: Array) -> Iterator[_Repair]:
    heights, which = np.unique(points[:, 2], return_inverse=True)
    if len(heights) > MAX_HEIGHTS:
        return
    upwards = tuple(range(len(heights)))
    for order in permutations(upwards):
        if order == upwards:
            continue
        down = ", or give Z_mm upwards" if order == upwards[::-1] else ""
        true = heights[list(order)]
        mistake = (
            f"its heights are in the wrong order: where Z_mm is {_mm(heights)}, its pixels fit {_mm(true)}; "
            f"correct the heights or the order of the pictures{down}"
        )
        yield (mistake, np.column_stack([points[:, :2], true[which]]), pixels)


def _mm(heights: Array) -> str:
    return ", ".join(f"{1e3 * float(height) + 0.0:g}" for height in heights)
