"""Which views of the cell are calibrated, and their projections."""

import numpy as np

from common.geometry import Array
from common.messages.requests import ViewCalibration
from remote_site.simulation.config import SIMULATED, CellConfig
from remote_site.simulation.views import simulated_calibration
from remote_site.video.config import CameraConfig, VideoConfig


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
