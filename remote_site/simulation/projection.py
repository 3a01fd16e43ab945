"""Where the simulated views show a point of the cell; pure, and without MuJoCo."""

import math

import numpy as np

from common.errors import ModelError
from common.geometry import Array
from common.messages.requests import ViewCalibration
from remote_site.simulation.config import ViewConfig

UP_IN_BASE = np.array([0.0, 0.0, 1.0])
UP_IN_TOOL = np.array([-1.0, 0.0, 0.0])
OPENGL_R_IMAGE = np.diag([1.0, -1.0, -1.0])  # pictures have y downwards and look along z


def calibration_of(view: ViewConfig, width: int, height: int) -> ViewCalibration:
    """How a view of this size in pixels sees the frame that it is fixed in."""
    focal = height / 2 / math.tan(math.radians(view.fovy_deg) / 2)
    pixels = np.array([[focal, 0.0, width / 2], [0.0, focal, height / 2], [0.0, 0.0, 1.0]])
    camera_R_parent = (parent_R_camera(view) @ OPENGL_R_IMAGE).T
    moved = np.column_stack([camera_R_parent, -camera_R_parent @ np.array(view.position_m)])
    return ViewCalibration(tuple((pixels @ moved).ravel().tolist()), on_tool=view.frame == "tool")


def parent_R_camera(view: ViewConfig) -> Array:
    """The rotation (3 x 3) of a view's camera, which looks along its -z, in the base's or the tool's frame."""
    up = UP_IN_TOOL if view.frame == "tool" else UP_IN_BASE
    return look_at(np.array(view.position_m), np.array(view.looks_at_m), up)


def look_at(position: Array, target: Array, up: Array) -> Array:
    """The rotation `parent_R_camera` (3 x 3) of a camera at `position` that looks along its -z to `target`.

    Raises ModelError when it would look along `up` or nowhere.
    """
    backward = position - target
    right = np.cross(up, backward)
    if min(np.linalg.norm(backward), np.linalg.norm(right)) < 1e-6:
        raise ModelError(f"a camera at {position} cannot look at {target}: move one of them")
    backward, right = backward / np.linalg.norm(backward), right / np.linalg.norm(right)
    return np.column_stack([right, np.cross(backward, right), backward])
