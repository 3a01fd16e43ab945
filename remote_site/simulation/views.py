"""Cameras of the cell, placed by where they stand and what they look at."""

import mujoco

from common.geometry import quaternion_from_rotation
from remote_site.simulation.config import ViewConfig
from remote_site.simulation.projection import parent_R_camera

CASE = (0.12, 0.13, 0.15, 1.0)


def add_view(body: mujoco.MjsBody, view: ViewConfig) -> None:
    """Add a camera to the world or to the tool; MuJoCo's cameras look along -z with y up."""
    x, y, z, w = quaternion_from_rotation(parent_R_camera(view))
    if view.frame == "tool":
        _add_mount(body, view)
    body.add_camera(name=view.name, pos=list(view.position_m), quat=[w, x, y, z], fovy=view.fovy_deg)


def _add_mount(tool: mujoco.MjsBody, view: ViewConfig) -> None:
    """The camera's case and its bracket, nearer to the camera than it sees, or out of its sight."""
    x, y, z = view.position_m
    box = mujoco.mjtGeom.mjGEOM_BOX
    for size, centre in (
        ((0.018, 0.022, 0.014), (x, y, z - 0.015)),
        ((abs(x) / 2, 0.008, 0.004), (x / 2, y, z - 0.025)),
    ):
        tool.add_geom(type=box, size=size, pos=centre, rgba=CASE, contype=0, conaffinity=0, mass=0)
