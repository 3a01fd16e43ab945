"""A camera's matrix and place, taken apart from the projection that configures it; pure."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import rq

from common.geometry import Array, transform
from common.messages.requests import ViewCalibration


class CameraFrame(NamedTuple):
    """The camera's matrix (3 x 3), from its frame (z ahead, y down) to pixels; `parent_T_camera` (4 x 4)."""

    pixels_T_camera: Array
    parent_T_camera: Array


def camera_frame(view: ViewCalibration) -> CameraFrame:
    """The frame of a calibrated view, in the base's frame, or in the tool's where the camera rides on it."""
    projection = np.reshape(view.projection, (3, 4))
    projection = projection * np.sign(np.linalg.det(projection[:, :3]))
    upper, turn = rq(projection[:, :3])
    signs = np.diag(np.sign(np.diag(upper)))
    upper, turn = upper @ signs, signs @ turn
    moved = np.linalg.solve(upper, projection[:, 3])
    return CameraFrame(upper / upper[2, 2], transform(turn.T, -turn.T @ moved))
