"""The cell's four views, rendered once while the arm moves along a closed path, and played in a loop afterwards."""

from pathlib import Path
from typing import Any

import numpy as np

from common.geometry import Array
from lab.stage.stand_ins.played_remote import FPS
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import CellConfig
from remote_site.video.cell_cameras import CellRenderer
from remote_site.video.config import VideoConfig

PICTURES = 3 * FPS
SWING_RAD = 0.1, 0.05  # of the first two joints: the tool goes a figure of eight at some 0.15 m/s


def render_source(folder: Path) -> None:
    """Write NAME.npy for each view of the default cell (see played_remote); CameraError where EGL is missing."""
    video, cell = VideoConfig(), build_cell(CellConfig(), RobotConfig())
    renderer = CellRenderer(cell, video.width, video.height)
    shape = PICTURES, video.height, video.width, 3
    for camera in video.cameras:
        images = np.lib.format.open_memmap(folder / f"{camera.name}.npy", "w+", np.uint8, shape)
        view = renderer.view_id(camera.name)
        for k in range(PICTURES):
            images[k] = renderer.render(view, _posture(cell.start().qpos, k))
        images.flush()
    renderer.close()


def _posture(start: Array, k: int) -> Any:
    phase = 2 * np.pi * k / PICTURES
    posture = start.copy()
    posture[:2] += np.array(SWING_RAD) * np.sin(np.array([1.0, 2.0]) * phase)
    return posture
