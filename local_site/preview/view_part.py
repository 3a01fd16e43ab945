"""A part of one view at the size in which it is sent: its picture, and what was found there, in the part's pixels."""

from dataclasses import dataclass, fields, replace
from typing import Any

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.tracking.tracker import ArmEstimate, Overlay


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
