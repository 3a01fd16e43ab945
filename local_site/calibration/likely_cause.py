"""What is most likely wrong with control points that fit no camera: the one mistake whose repair makes them fit."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from common.geometry import Array
from local_site.calibration.checks import fits_no_camera
from local_site.calibration.dlt import reprojection_errors, solve_projection
from local_site.calibration.physical_camera import PhysicalCamera, decomposed

MAX_HEIGHTS = 4
MIN_TO_THE_RIGHT = 0.5
MIN_AWAY = -0.3
AXES = "correct the axes of the control points (x right, y away, z up)"


@dataclass(frozen=True, slots=True)
class _Repair:
    """A mistake in words, with the points (N, 3) in m and the pixels (N, 2) as they are without it."""

    mistake: str
    points: Array
    pixels: Array


def likely_cause(points: Array, pixels: Array) -> str:
    """The one mistake, with its cure, without which points (N, 3) in m and pixels (N, 2) fit a camera; empty if none.

    Mirrored pictures, exchanged axes and heights in the wrong order can fit equally well; what tells them apart is that
    a camera stands the right way: x to its right, y away from it, and rather above the points than below.
    """
    found: list[tuple[bool, float, str]] = []
    for repair in _repairs(points, pixels):
        projection = solve_projection(repair.points, repair.pixels)
        residuals = reprojection_errors(projection, repair.points, repair.pixels)
        camera = decomposed(projection)
        if camera is not None and _stands_right(camera) and not fits_no_camera(residuals, repair.pixels):
            below = bool(camera.centre[2] < repair.points[:, 2].mean())
            found.append((below, round(float(np.median(residuals)), 3), repair.mistake))
    return min(found)[2] if found else ""


def _stands_right(camera: PhysicalCamera) -> bool:
    to_the_right, _, ahead = camera.camera_R_operator
    return float(to_the_right[0]) > MIN_TO_THE_RIGHT and float(ahead[1]) > MIN_AWAY


def _repairs(points: Array, pixels: Array) -> Iterator[_Repair]:
    mirrored = f"sees the points mirrored; switch off the mirroring of its picture or, if X_mm runs to the left, {AXES}"
    yield _Repair(mirrored, points, pixels * (-1.0, 1.0))
    yield _Repair("sees the points upside down and mirrored; count v from the top", points, pixels * (1.0, -1.0))
    yield _Repair("its u and v are exchanged; give u along the rows first", points, pixels[:, ::-1])
    towards = f"sees the points mirrored, as if Y_mm ran towards the cameras; {AXES}"
    yield _Repair(towards, points * (1.0, -1.0, 1.0), pixels)
    yield _Repair(f"sees the points mirrored, as if X_mm and Y_mm were exchanged; {AXES}", points[:, [1, 0, 2]], pixels)
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
        yield _Repair(mistake, np.column_stack([points[:, :2], true[which]]), pixels)


def _mm(heights: Array) -> str:
    return ", ".join(f"{1e3 * float(height) + 0.0:g}" for height in heights)
