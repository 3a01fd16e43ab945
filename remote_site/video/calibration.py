"""Which views of the cell are calibrated, and how they see it."""

import numpy as np

from common.messages.requests import ViewCalibration
from remote_site.config import RemoteConfig
from remote_site.simulation import projection
from remote_site.simulation.config import SIMULATED
from remote_site.video.config import CameraConfig


def calibration_of(camera: CameraConfig, config: RemoteConfig) -> ViewCalibration | None:
    """How this camera sees the cell, from the configuration or as it is simulated; None where that is not known."""
    if camera.projection is not None:
        return ViewCalibration(camera.projection, camera.on_tool)
    if camera.source != SIMULATED or not config.video.calibrated:
        return None
    view = next((view for view in config.simulation.views if view.name == camera.name), None)
    if view is None:
        return None
    seen = projection.calibration_of(view, config.video.width, config.video.height)
    return _from_tool_centre(seen, config) if seen.on_tool else seen


def _from_tool_centre(seen: ViewCalibration, config: RemoteConfig) -> ViewCalibration:
    """Simulated views ride on the flange; what others know of the tool is its centre point."""
    moved = np.reshape(seen.projection, (3, 4)) @ config.robot.tool_T_tcp
    return ViewCalibration(tuple(moved.ravel().tolist()), on_tool=True)
