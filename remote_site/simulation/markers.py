"""Printed markers in the simulated cell's views: plates that nothing touches, on the block or beside it."""

import mujoco
import numpy as np

from common.geometry import Array, quaternion_from_rotation
from remote_site.simulation.config import BLOCK, MarkerConfig
from remote_site.simulation.scenery import PAPER

MODULE_PX = 24  # of the texture: the renderer averages it as a camera does
LIT = 1.0  # emission that outshines every light: paper as white from everywhere
PLATE_M = 0.001


def add_marker(spec: mujoco.MjSpec, number: int, config: MarkerConfig) -> None:
    """Put a printed marker with a white module around it on the block, or fix it in the base's frame."""
    body = spec.body(BLOCK) if config.on == BLOCK else spec.worldbody
    name, pose = f"marker_{number}", config.parent_T_marker
    printed = config.family.printed(config.marker, MODULE_PX)
    half = config.size_m / 2 * len(printed) / (len(printed) - 2 * MODULE_PX)
    _add_material(spec, name, np.repeat(printed[:, :, None], 3, axis=2))
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    square = np.array([(-half, -half, 0.0), (half, -half, 0.0), (half, half, 0.0), (-half, half, 0.0)])
    mesh.uservert = (square @ pose[:3, :3].T + pose[:3, 3]).ravel().tolist()
    mesh.usertexcoord = [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    mesh.userface = [0, 1, 2, 0, 2, 3]
    _untouchable(body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=name))
    _untouchable(_plate(body, pose, half))


def _plate(body: mujoco.MjsBody, pose: Array, half: float) -> mujoco.MjsGeom:
    """The paper behind the print."""
    *imaginary, real = quaternion_from_rotation(pose[:3, :3])
    centre = pose[:3, 3] - PLATE_M * pose[:3, 2]
    size = [half, half, PLATE_M / 2]
    return body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=centre.tolist(), quat=[real, *imaginary], rgba=PAPER
    )


def _untouchable(geom: mujoco.MjsGeom) -> None:
    geom.contype, geom.conaffinity, geom.mass = 0, 0, 0.0


def _add_material(spec: mujoco.MjSpec, name: str, picture: np.ndarray) -> None:
    height, width = picture.shape[:2]
    texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, height=height, width=width, nchannel=3)
    texture.data = picture.tobytes()
    material = spec.add_material(name=name, emission=LIT, rgba=[1.0, 1.0, 1.0, 1.0])
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
