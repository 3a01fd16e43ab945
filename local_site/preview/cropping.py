"""Chooses the part of each of the operator's views that is sent: where the tracker found the arm."""

from dataclasses import dataclass, fields, replace
from typing import Any

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from common.messages.hand import FOUND
from local_site.preview.arm_window import WHOLE, ArmWindow, PictureBox
from local_site.tracking.tracker import ArmEstimate, Overlay

PART_WIDTH = 2 / 3  # of the whole picture as it is sent: as wide a part may be sent, where the camera has the pixels


@dataclass(frozen=True, slots=True)
class ViewPart:
    """Whole pixels of a camera's picture, sent `sent_width` px wide, which is no more than `width`."""

    left: int
    top: int
    width: int
    height: int
    sent_width: int

    def picture(self, whole: Image) -> Image:
        """The part of a picture (H, W) or (H, W, 3)."""
        part = whole[self.top : self.top + self.height, self.left : self.left + self.width]
        if self.sent_width == self.width:
            return part
        size = self.sent_width, round(self.height * self._scale)
        return np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)

    def estimate(self, estimate: ArmEstimate, view: int) -> ArmEstimate:
        """The estimate with this view's overlay in the pixels of the part."""
        overlays = list(estimate.overlays)
        overlays[view : view + 1] = [self._overlay(overlay) for overlay in overlays[view : view + 1]]
        return replace(estimate, overlays=tuple(overlays))

    def projection(self, projection: Array) -> Array:
        """A camera's matrix (3, 4), to the pixels of the part."""
        across, down = self._pixels(np.zeros(2))
        to_part = np.array([[self._scale, 0.0, across], [0.0, self._scale, down], [0.0, 0.0, 1.0]])
        return np.asarray(to_part @ projection)

    @property
    def _scale(self) -> float:
        return self.sent_width / self.width

    def _overlay(self, overlay: Overlay) -> Overlay:
        drawn = {field.name: getattr(overlay, field.name) for field in fields(overlay)}
        moved: dict[str, Any] = {name: self._pixels(shape) for name, shape in drawn.items() if shape is not None}
        if "contour" in moved:
            moved["contour"] = np.rint(moved["contour"]).astype(np.int32)
        return replace(overlay, **moved)

    def _pixels(self, whole: Array) -> Array:
        """Pixels (..., 2) of the whole picture, whose centres are whole numbers, as pixels of the part."""
        half = 0.5
        return np.asarray((whole - (self.left, self.top) + half) * self._scale - half)


class Cropping:
    """The parts of all views as they are shown, where a whole picture is sent `sent_width` px wide at most.

    A single camera's picture stays whole: the operator marks joints in it, also such as the tracker did not find.
    """

    def __init__(self, cameras: int, sent_width: int) -> None:
        self._windows = [ArmWindow() for _ in range(cameras)] if cameras > 1 else []
        self._sent_width = sent_width

    def part(self, estimate: ArmEstimate, view: int, width: int, height: int) -> ViewPart:
        """The part of a view's picture of this size in px to be shown at the estimate's instant."""
        shown = WHOLE
        if self._windows:
            shown = self._windows[view].at(estimate.t_ns, arm_box(estimate, view, width, height))
        side = shown.right - shown.left
        across, down = round(side * width), round(side * height)
        left, top = min(round(shown.left * width), width - across), min(round(shown.top * height), height - down)
        sent_width = round(max(side, PART_WIDTH) * self._sent_width)
        return ViewPart(left, top, across, down, min(across, sent_width))


def arm_box(estimate: ArmEstimate, view: int, width: int, height: int) -> PictureBox | None:
    """Find the box of the arm in a picture of this size in px; None where no arm is tracked in this view."""
    if estimate.status not in FOUND or view >= len(estimate.overlays):
        return None
    drawn = (getattr(estimate.overlays[view], field.name) for field in fields(Overlay))
    pixels = [np.reshape(shape, (-1, 2)) for shape in drawn if shape is not None]
    points = np.concatenate([np.empty((0, 2)), *pixels])
    x, y = points[:, 0] / width, points[:, 1] / height
    finite = np.isfinite(x) & np.isfinite(y)
    x, y = x[finite], y[finite]
    if not ((x >= 0) & (x <= 1) & (y >= 0) & (y <= 1)).any():
        return None
    left, top, right, bottom = (min(max(float(end), 0.0), 1.0) for end in (x.min(), y.min(), x.max(), y.max()))
    return PictureBox(left, top, right, bottom)
