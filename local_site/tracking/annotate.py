"""What the tracker saw, drawn over a frame for people: contour, medial lines, joints, tips and status."""

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from common.messages import TrackingStatus
from local_site.tracking.tracker import ArmEstimate, Overlay

Colour = tuple[int, int, int]

CONTOUR: Colour = (150, 110, 40)
LINE: Colour = (200, 200, 200)
POINTS: dict[str, Colour] = {
    "elbow": (60, 76, 231),
    "wrist": (90, 200, 80),
    "index": (230, 150, 50),
    "thumb": (40, 200, 240),
}
STATUS: dict[TrackingStatus, Colour] = {
    TrackingStatus.INITIALISING: (40, 200, 240),
    TrackingStatus.TRACKED: (90, 200, 80),
    TrackingStatus.DEGRADED: (40, 150, 240),
    TrackingStatus.LOST: (60, 76, 231),
}
SHIFT = 4
LINE_HEIGHT_PX = 18


def annotate(image: Image, estimate: ArmEstimate, view: int) -> Image:
    """A copy of a frame (H, W) or (H, W, 3) in BGR with what was found in it."""
    canvas = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else np.ascontiguousarray(image[..., :3]).copy()
    if view < len(estimate.overlays):
        _draw(canvas, estimate.overlays[view])
    text = estimate.status.value + (f": {estimate.reason}" if estimate.reason else "")
    cv2.putText(
        canvas, text, (6, LINE_HEIGHT_PX), cv2.FONT_HERSHEY_SIMPLEX, 0.4, STATUS[estimate.status], 1, cv2.LINE_AA
    )
    return np.asarray(canvas, dtype=np.uint8)


def _draw(canvas: cv2.typing.MatLike, overlay: Overlay) -> None:
    if overlay.contour is not None and len(overlay.contour):
        cv2.polylines(canvas, [overlay.contour], isClosed=True, color=CONTOUR, lineType=cv2.LINE_AA)
    for line in (overlay.forearm_line, overlay.upper_arm_line):
        if line is not None:
            cv2.line(canvas, _fixed(line[0]), _fixed(line[1]), LINE, 1, cv2.LINE_AA, SHIFT)
    for name, colour in POINTS.items():
        point: Array | None = getattr(overlay, name)
        if point is not None:
            cv2.circle(canvas, _fixed(point), 4 << SHIFT, colour, 1, cv2.LINE_AA, SHIFT)


def _fixed(point: Array) -> tuple[int, int]:
    """A pixel in OpenCV's fixed-point drawing coordinates, kept within what they can hold."""
    x, y = np.clip(np.nan_to_num(point), -1e4, 1e4) * (1 << SHIFT)
    return round(float(x)), round(float(y))
