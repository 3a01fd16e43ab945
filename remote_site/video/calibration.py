"""Calibration of the cell's views: which have one, their projections, and whether their pictures fit these."""

import numpy as np
import structlog

from common.cameras.camera import Frame
from common.geometry import Array
from common.messages.requests import ViewCalibration
from remote_site.simulation.config import SIMULATED, CellConfig
from remote_site.simulation.views import simulated_calibration
from remote_site.video.config import CameraConfig, VideoConfig


def size_of(camera: CameraConfig, video: VideoConfig) -> tuple[int, int]:
    """The width and height of the pictures that a camera's calibration is for, px."""
    return camera.size_px or (video.width, video.height)


def calibration_of(
    camera: CameraConfig, video: VideoConfig, cell: CellConfig, tool_T_tcp: Array
) -> ViewCalibration | None:
    """A camera's calibration, configured or simulated; None where it is unknown.

    Simulated views ride on the tool frame, `tool_T_tcp` (4 x 4) takes them to the tool centre point.
    """
    if camera.projection is not None:
        return ViewCalibration(camera.projection, camera.on_tool)
    view = next((view for view in cell.views if view.name == camera.name), None)
    if camera.source != SIMULATED or not video.calibrated or view is None:
        return None
    seen = simulated_calibration(view, video.width, video.height)
    if not seen.on_tool:
        return seen
    moved = np.reshape(seen.projection, (3, 4)) @ tool_T_tcp
    return ViewCalibration(tuple(moved.ravel().tolist()), on_tool=True)


class FittingPictures:
    """Tells pictures that a calibration is for from pictures of another size, which say nothing of where things are."""

    def __init__(self, config: VideoConfig) -> None:
        self._sizes_px = {camera.name: size_of(camera, config) for camera in config.cameras}
        self._calibrated = {camera.name for camera in config.cameras if camera.projection is not None}

    def fits(self, view: str, frame: Frame) -> bool:
        """Return whether the picture has the size that its view's calibration is for; log once where it has not."""
        size, seen = self._sizes_px[view], frame.image.shape[1::-1]
        if seen == size:
            return True
        if view in self._calibrated:
            self._calibrated.discard(view)
            why = f"its pictures have {seen[0]} x {seen[1]} pixels, and its projection is for {size[0]} x {size[1]}"
            cure = f"a projection for these pictures, and size_px = [{seen[0]}, {seen[1]}] in [[video.cameras]]"
            structlog.get_logger().warning("a projection is not used", view=view, reason=why, cure=cure)
        return False
