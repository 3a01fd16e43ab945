"""The simulated views without MuJoCo: their projections, and an arm shown in them that is not simulated."""

import math

import numpy as np

from common.errors import ModelError
from common.geometry import Array
from common.messages.requests import ViewCalibration
from remote_site.shared_record import SharedRecord
from remote_site.simulation.config import CellConfig, ViewConfig
from remote_site.simulation.memory import FINGERS

UPRIGHT = (1.0, 0.0, 0.0, 0.0)  # MuJoCo's quaternions begin with the real part
UP_IN_BASE = np.array([0.0, 0.0, 1.0])
UP_IN_TOOL = np.array([-1.0, 0.0, 0.0])
OPENGL_R_IMAGE = np.diag([1.0, -1.0, -1.0])  # pictures have y downwards and look along z


def simulated_calibration(view: ViewConfig, width: int, height: int) -> ViewCalibration:
    """The projection of a view of this size in pixels, from the frame that it is fixed in."""
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


class PostureMirror:
    """Shows measured joints in an otherwise unchanged cell: writes the snapshot that the views are rendered from."""

    def __init__(self, config: CellConfig, snapshot: SharedRecord) -> None:
        self._snapshot = snapshot
        self._record = np.zeros((), dtype=snapshot.dtype)
        x, y = config.block.centre_xy_m
        z = config.scene.table_z_m + config.block.size_m[2] / 2
        self._rest = np.array([*(0.0,) * FINGERS, x, y, z, *UPRIGHT])

    def show(self, t_ns: int, q: Array) -> None:
        """Show the arm at `q` (n,) rad as measured at `t_ns`."""
        self._record["t_ns"] = t_ns
        self._record["qpos"] = np.concatenate([q, self._rest])
        self._snapshot.write(self._record)
