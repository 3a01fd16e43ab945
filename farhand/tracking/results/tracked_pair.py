"""A tracked pair as the results take it, with its picture, which is drawn once and only if one of them wants it."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from common.cameras.camera import Image
from farhand.tracking.track_line import TrackLine
from local_site.calibration.rig import Rig
from local_site.tracking.annotate import FONT, FONT_SCALE, LINE, LINE_HEIGHT_PX, MARGIN_PX, annotate
from local_site.tracking.tracker import ArmEstimate, Views


@dataclass(frozen=True)
class TrackedPair:
    """The views of one instant, what was found in them, and its line; `t_s` counts from the first pair."""

    rig: Rig
    views: Views
    estimate: ArmEstimate
    line: TrackLine
    t_s: float

    @cached_property
    def picture(self) -> Image:
        """All views side by side with what was found in them (H, W, 3), BGR, above a line with number and time."""
        cameras = enumerate(zip(self.views.views, self.rig.matrices, strict=True))
        pictures = [annotate(view.current.image, self.estimate, k, matrix) for k, (view, matrix) in cameras]
        height = max(picture.shape[0] for picture in pictures) + LINE_HEIGHT_PX
        canvas = np.hstack([np.pad(p, ((0, height - p.shape[0]), (0, 0), (0, 0))) for p in pictures])
        at = (MARGIN_PX, height - MARGIN_PX)
        cv2.putText(canvas, self._caption(), at, FONT, FONT_SCALE, LINE, 1, cv2.LINE_AA)
        return canvas

    def _caption(self) -> str:
        names = ", ".join(camera.name for camera in self.rig.cameras)
        residual = self.line.residual_px
        between = "" if residual is None else f"   residual between views {residual:.2f} px"
        return f"pair {self.line.frame}   {self.t_s:.3f} s   {names}{between}"


Take = Callable[[TrackedPair], object]
Result = AbstractContextManager[Take]  # entered, it takes pairs; left, it is complete, whatever has ended the track
