"""Draws a tracker's result over a frame: contour, medial lines, joints, tips, sigmas, status and reason."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.triangulation import image_of
from local_site.kernels.pictures import as_colour
from local_site.tracking.tracker import ArmEstimate, Overlay

Colour = tuple[int, int, int]

CONTOUR: Colour = (210, 150, 60)
LINE: Colour = (255, 255, 255)
DARK: Colour = (0, 0, 0)
DIM: Colour = (150, 150, 150)
POINTS: dict[str, Colour] = {
    "elbow": (80, 90, 255),
    "wrist": (90, 220, 80),
    "index": (255, 160, 60),
    "thumb": (40, 210, 250),
}
STATUS: dict[TrackingStatus, Colour] = {
    TrackingStatus.INITIALISING: (40, 200, 240),
    TrackingStatus.TRACKED: (90, 220, 80),
    TrackingStatus.DEGRADED: (40, 150, 250),
    TrackingStatus.LOST: (80, 90, 255),
}
SHIFT = 4
FONT, FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.45
MARGIN_PX, LINE_HEIGHT_PX = 6, 18
LEAST_LINES = 12  # below the status, for the points' lines: in a lower picture they would hide the arm
PAD_PX, DARKENED = 3, 4
DOT_PX = 2.5
SIGMAS = 2.0
FARTHEST_PX = 1e4
_TURN = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
_CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)])


def annotate(image: Image, estimate: ArmEstimate, view: int, projection: Array | None = None) -> Image:
    """A copy of a frame (H, W) or (H, W, 3) in BGR with what was found in it.

    With the camera's `projection` (3, 4), an ellipse of two sigma surrounds every point that has a covariance.
    """
    canvas = as_colour(image) if image.ndim == 2 else np.array(image[..., :3], order="C")
    if canvas.shape[0] - _write_status(canvas, estimate) >= LEAST_LINES * LINE_HEIGHT_PX:
        _write_sigmas(canvas, estimate)
    if view < len(estimate.overlays):
        _draw_shape(canvas, estimate.overlays[view])
        for name in POINTS:
            _draw_point(canvas, name, estimate, estimate.overlays[view], projection)
    return canvas


def _draw_shape(canvas: Image, overlay: Overlay) -> None:
    if overlay.contour is not None and len(overlay.contour):
        cv2.polylines(canvas, [overlay.contour], isClosed=True, color=CONTOUR, lineType=cv2.LINE_AA)
    limbs = (overlay.forearm_line, overlay.upper_arm_line)
    lines = [(_fixed(line[0]), _fixed(line[1])) for line in limbs if line is not None]
    for colour, width in ((DARK, 3), (LINE, 1)):
        for start, end in lines:
            cv2.line(canvas, start, end, colour, width, cv2.LINE_AA, SHIFT)


def _draw_point(canvas: Image, name: str, estimate: ArmEstimate, overlay: Overlay, projection: Array | None) -> None:
    """A dot, a ring if the point was inferred, and the ellipse of its sigma; nothing where it was not found."""
    pixel: Array | None = getattr(overlay, name)
    point: Array | None = getattr(estimate, name)
    if pixel is None or point is None:
        return
    inferred = name == "thumb" and estimate.thumb_inferred
    centre, radius = _fixed(pixel), round(DOT_PX * (1 << SHIFT))
    for colour, more in ((DARK, 1 << SHIFT), (POINTS[name], 0)):
        thickness = (3 if more else 1) if inferred else cv2.FILLED
        cv2.circle(canvas, centre, radius + more * (not inferred), colour, thickness, cv2.LINE_AA, SHIFT)
    covariance = estimate.covariances.get(name)
    if projection is None or covariance is None or not np.all(np.isfinite(covariance)):
        return
    if projection[2, :3] @ point + projection[2, 3] > 0:
        outline = sigma_outline(projection, point, covariance) + pixel
        cv2.polylines(
            canvas, [_all_fixed(outline)], isClosed=True, color=POINTS[name], lineType=cv2.LINE_AA, shift=SHIFT
        )


def sigma_outline(projection: Array, point: Array, covariance: Array) -> Array:
    """The ellipse of two sigma about the image of a point (3,) in m, as pixels (36, 2) from its centre.

    The covariance (3, 3) in m² is propagated through the Jacobian of the projection (3, 4).
    """
    _, jacobian, _ = image_of(projection, point)
    (a, b), (_, d) = (jacobian @ covariance @ jacobian.T).tolist()
    mean, half, turn = (a + d) / 2, math.hypot((a - d) / 2, b), math.atan2(2 * b, a - d) / 2
    long, short = SIGMAS * math.sqrt(max(mean + half, 0.0)), SIGMAS * math.sqrt(max(mean - half, 0.0))
    c, s = math.cos(turn), math.sin(turn)
    outline: Array = _CIRCLE @ np.array([[long * c, long * s], [-short * s, short * c]])
    return outline


def _write_status(canvas: Image, estimate: ArmEstimate) -> int:
    """The status, and the reason in as many lines as it takes, at the top; their height in px."""
    text = estimate.status.value + (f": {estimate.reason}" if estimate.reason else "")
    lines = wrapped(text, canvas.shape[1] - 2 * MARGIN_PX)
    for row, line in enumerate(lines, start=1):
        _write(canvas, line, (MARGIN_PX, row * LINE_HEIGHT_PX), STATUS[estimate.status])
    return len(lines) * LINE_HEIGHT_PX + MARGIN_PX


def _write_sigmas(canvas: Image, estimate: ArmEstimate) -> None:
    """Each point's name in its colour with its sigma in mm, one below the other at the bottom."""
    first = canvas.shape[0] - MARGIN_PX - LINE_HEIGHT_PX * (len(POINTS) - 1)
    for row, (name, colour) in enumerate(POINTS.items()):
        at = (MARGIN_PX, first + row * LINE_HEIGHT_PX)
        if getattr(estimate, name) is None:
            _write(canvas, f"{name} not found", at, DIM)
            continue
        text = f"{name} inferred" if name == "thumb" and estimate.thumb_inferred else name
        if name in estimate.covariances:
            text += f" ±{1e3 * float(np.sqrt(np.trace(estimate.covariances[name]))):.1f} mm"
        _write(canvas, text, at, colour)


def wrapped(text: str, width_px: int) -> list[str]:
    """The text in lines of whole words that fit into a width; a word that is too long has a line of its own."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and cv2.getTextSize(longer, FONT, FONT_SCALE, 1)[0][0] > width_px:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def _write(canvas: Image, text: str, at: tuple[int, int], colour: Colour) -> None:
    """Text on a darkened strip, readable before any picture."""
    (width, height), below = cv2.getTextSize(text, FONT, FONT_SCALE, 1)
    x, y = at
    strip = canvas[max(y - height - PAD_PX, 0) : max(y + below, 0), max(x - PAD_PX, 0) : x + width + PAD_PX]
    strip //= DARKENED
    cv2.putText(canvas, text, at, FONT, FONT_SCALE, colour, 1, cv2.LINE_AA)


def _fixed(point: Array) -> tuple[int, int]:
    """A pixel in OpenCV's fixed-point drawing coordinates, kept within what they can hold."""
    x, y = point.tolist()
    return _fixed_number(x), _fixed_number(y)


def _fixed_number(at: float) -> int:
    return 0 if math.isnan(at) else round(min(max(at, -FARTHEST_PX), FARTHEST_PX) * (1 << SHIFT))


def _all_fixed(points: Array) -> NDArray[np.int32]:
    """Pixels (n, 2) in the same coordinates."""
    kept: Array = np.where(np.isnan(points), 0.0, np.clip(points, -FARTHEST_PX, FARTHEST_PX))
    return np.asarray(np.rint(kept * (1 << SHIFT)), dtype=np.int32)
