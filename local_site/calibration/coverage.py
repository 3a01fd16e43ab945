"""Coverage: how much of the pictures and of the volume a calibration's points reach, as warnings and as a picture."""

from collections.abc import Sequence

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.control_points import ControlPoints, Size
from local_site.kernels.pictures import as_colour

MIN_PICTURE = 0.4
MIN_AXIS = 0.6
MIN_COMMON = 12
CELLS = (8, 6)
GOOD, EMPTY, DOT = (60, 140, 60), (40, 40, 150), (255, 255, 255)


def picture_coverage(pixels: Array, size: Size) -> float:
    """The part of a picture of this size (width, height) that lies within the convex hull of pixels (N, 2)."""
    inside = pixels[np.isfinite(pixels[:, 0])]
    if len(inside) < 3:
        return 0.0
    hull = cv2.convexHull(inside.astype(np.float32))
    return float(cv2.contourArea(hull)) / (size[0] * size[1])


def coverage_warnings(control: ControlPoints) -> tuple[str, ...]:
    """Say what is poorly covered, a sentence with its cure each; pictures of unknown size are not judged."""
    sentences = []
    for name, pixels, size in zip(control.cameras, control.pixels, control.sizes, strict=False):
        covered = 1.0 if size is None else picture_coverage(pixels, size)
        if covered < MIN_PICTURE:
            sentences.append(
                f"{name} camera: the points cover {100 * covered:.0f} % of its picture, less than "
                f"{100 * MIN_PICTURE:.0f} %; outside them the lens is guessed, so bring points nearer to its edges"
            )
    return (*sentences, *_volume_warnings(control))


def _volume_warnings(control: ControlPoints) -> list[str]:
    views = np.sum([np.isfinite(pixels[:, 0]) for pixels in control.pixels], axis=0)
    common = control.points[views >= 2]
    sentences = []
    if len(common) < MIN_COMMON:
        sentences.append(
            f"only {len(common)} points are seen by two cameras; show {MIN_COMMON} or more to estimate the error"
        )
    whole = np.maximum(np.ptp(control.points, axis=0), 1e-9)
    parts = np.ptp(common, axis=0) / whole if len(common) else np.zeros(3)
    for axis, part in zip("XYZ", parts, strict=True):
        if part < MIN_AXIS:
            sentences.append(
                f"the points seen by two cameras span {100 * part:.0f} % of the volume along {axis}; "
                "turn the cameras so that both see more of it"
            )
    return sentences


def coverage_map(pixels: Array, size: Size, picture: Image | None = None) -> Image:
    """A picture (H, W, 3) of where points (N, 2) were seen: cells without a point are red, with one green."""
    width, height = size
    canvas = np.zeros((height, width, 3), dtype=np.uint8) if picture is None else as_colour(picture)
    inside = pixels[np.isfinite(pixels[:, 0])]
    edges = [np.linspace(0, extent, count + 1) for extent, count in zip(size, CELLS, strict=True)]
    counts = np.histogram2d(inside[:, 0], inside[:, 1], bins=(edges[0], edges[1]))[0]
    tint = canvas.copy()
    for column, row in np.ndindex(*CELLS):
        corners = [(round(edges[0][column + k]) + 1 - 3 * k, round(edges[1][row + k]) + 1 - 3 * k) for k in (0, 1)]
        cv2.rectangle(tint, corners[0], corners[1], GOOD if counts[column, row] else EMPTY, cv2.FILLED)
    mixed = cv2.addWeighted(canvas, 0.5, tint, 0.5, 0.0)
    for u, v in inside:
        cv2.circle(mixed, (round(float(u)), round(float(v))), 2, DOT, cv2.FILLED, cv2.LINE_AA)
    return np.asarray(mixed, dtype=np.uint8)


CROSS, NAME = (60, 220, 60), (60, 200, 255)


def draw_found(picture: Image, pixels: Array, names: Sequence[str]) -> Image:
    """The picture in colour (H, W, 3) with a cross and a name at each of the pixels (N, 2), joined in their order."""
    canvas = as_colour(picture).copy()
    centres = [(round(float(u)), round(float(v))) for u, v in pixels]
    cv2.polylines(canvas, [np.array(centres, dtype=np.int32).reshape(-1, 1, 2)], False, NAME, 1, cv2.LINE_AA)
    for centre, name in zip(centres, names, strict=True):
        cv2.drawMarker(canvas, centre, CROSS, cv2.MARKER_CROSS, 9, 1, cv2.LINE_AA)
        cv2.putText(canvas, name, (centre[0] + 5, centre[1] - 5), cv2.FONT_HERSHEY_SIMPLEX, 0.35, NAME, 1, cv2.LINE_AA)
    return canvas
