"""Cameras of the cell, placed by where they stand and what they look at."""

import mujoco
import numpy as np

from common.errors import ModelError
from common.geometry import Array, quaternion_from_rotation
from remote_site.simulation.config import ViewConfig

UP_IN_BASE = np.array([0.0, 0.0, 1.0])
UP_IN_TOOL = np.array([-1.0, 0.0, 0.0])
CASE = (0.12, 0.13, 0.15, 1.0)


def add_view(body: mujoco.MjsBody, view: ViewConfig) -> None:
    """Add a camera to the world or to the tool; MuJoCo's cameras look along -z with y up."""
    up = UP_IN_TOOL if view.frame == "tool" else UP_IN_BASE
    x, y, z, w = quaternion_from_rotation(look_at(np.array(view.position_m), np.array(view.looks_at_m), up))
    if view.frame == "tool":
        _add_mount(body, view)
    body.add_camera(name=view.name, pos=list(view.position_m), quat=[w, x, y, z], fovy=view.fovy_deg)


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


def _add_mount(tool: mujoco.MjsBody, view: ViewConfig) -> None:
    """The camera's case and its bracket, nearer to the camera than it sees, or out of its sight."""
    x, y, z = view.position_m
    box = mujoco.mjtGeom.mjGEOM_BOX
    for size, centre in (
        ((0.018, 0.022, 0.014), (x, y, z - 0.015)),
        ((abs(x) / 2, 0.008, 0.004), (x / 2, y, z - 0.025)),
    ):
        tool.add_geom(type=box, size=size, pos=centre, rgba=CASE, contype=0, conaffinity=0, mass=0)
