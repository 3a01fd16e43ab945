"""Dresses the cell for the views: pictures of room, furniture and table around what moves, which keeps its plain paint.

Light and shadows are in the pictures, as they fall in the standard cell; around another table they stay where they are.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import mujoco
import numpy as np

from common.cameras.camera import Image
from common.errors import ModelError
from common.geometry import Array
from remote_site.simulation.config import SceneConfig
from remote_site.simulation.scenery import ROOM_GROUP, TABLE_THICKNESS_M

PICTURES = Path(__file__).parent / "pictures"
LIT = 1.0  # emission that outshines every light: what is baked into the texture is all that is seen
UNSEEN = (0.0, 0.0, 0.0, 0.0)
ROOM_LOW_M, ROOM_HIGH_M, ROOM_HEIGHT_M = (-1.6, -3.0), (3.2, 2.2), 3.0


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle seen from its front: lower left corner and the edges to the right and upwards (3,), m."""

    corner: Array
    right: Array
    up: Array

    @property
    def normal(self) -> Array:
        """The unit vector towards whoever sees the rectangle."""
        across = np.cross(self.right, self.up)
        return np.asarray(across / np.linalg.norm(across), dtype=float)


@dataclass(frozen=True, slots=True)
class PaintedSurface:
    """A rectangle with its picture (H, W, 3), BGR, light included; of the table, or of the room behind everything."""

    rectangle: Rectangle
    picture: Image
    of_table: bool


def dress(spec: mujoco.MjSpec, scene: SceneConfig) -> tuple[PaintedSurface, ...]:
    """Put furniture around the cell and return the surfaces of room and table.

    Nothing that is added can be touched. Furniture is of `ROOM_GROUP`. What moves keeps its plain paint: textures on it
    would take the software renderer longer than all the rest of a view.
    """
    spec.geom("floor").rgba = UNSEEN
    _add_furniture(spec, scene.floor_z_m)
    room = [PaintedSurface(side, _picture(name), False) for name, side in _room(scene.floor_z_m)]
    table = [PaintedSurface(side, _picture(name), True) for name, side in _table(scene)]
    return (*room, *table)


def _room(floor_z_m: float) -> Iterator[tuple[str, Rectangle]]:
    (x0, y0), (x1, y1), z0 = ROOM_LOW_M, ROOM_HIGH_M, floor_z_m
    x, y, z = np.diag([x1 - x0, y1 - y0, ROOM_HEIGHT_M])
    yield "floor", Rectangle(np.array([x1, y0, z0]), y, -x)
    yield "back", Rectangle(np.array([x0, y0, z0]), y, z)
    yield "side", Rectangle(np.array([x0, y1, z0]), x, z)
    yield "front", Rectangle(np.array([x1, y1, z0]), -y, z)
    yield "near", Rectangle(np.array([x1, y0, z0]), -x, z)


def _table(scene: SceneConfig) -> Iterator[tuple[str, Rectangle]]:
    """The six sides of the table's top."""
    (length, width), top = scene.table_size_xy_m, np.array([*scene.table_centre_xy_m, scene.table_z_m])
    half = np.array([length / 2, width / 2, 0.0])
    low, high = top - half - (0.0, 0.0, TABLE_THICKNESS_M), top + half
    x, y, z = np.diag(high - low)
    yield "table_far", Rectangle(np.array([high[0], low[1], low[2]]), y, z)
    yield "table_near", Rectangle(np.array([low[0], high[1], low[2]]), -y, z)
    yield "table_left", Rectangle(np.array([high[0], high[1], low[2]]), -x, z)
    yield "table_right", Rectangle(low, x, z)
    yield "table_under", Rectangle(low, y, x)
    yield "table_top", Rectangle(np.array([high[0], low[1], high[2]]), y, -x)


def _picture(name: str) -> Image:
    picture = cv2.imread(str(PICTURES / f"{name}.jpg"), cv2.IMREAD_COLOR_BGR)
    if picture is None:
        raise ModelError(f"{PICTURES / name}.jpg is missing or damaged; install Farhand again")
    return np.asarray(picture, dtype=np.uint8)


def _add_furniture(spec: mujoco.MjSpec, floor_z_m: float) -> None:
    """Stand the boxes of rack, bench and cartons on the floor."""
    with np.load(PICTURES / "furniture.npz") as faces:  # four vertices each (4 n, 3), m above the floor, and texels
        vertices, texels = faces["vertices"] + np.array([0.0, 0.0, floor_z_m]), faces["texels"]
    picture = np.asarray(cv2.cvtColor(_picture("furniture"), cv2.COLOR_BGR2RGB), dtype=np.uint8)
    add_pictured_rectangles(spec, spec.worldbody, "furniture", picture, vertices, texels).group = ROOM_GROUP


def add_pictured_rectangles(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, name: str, picture: Image, vertices: Array, texels: Array
) -> mujoco.MjsGeom:
    """Add rectangles that nothing touches to a body: one mesh with one texture, RGB, as bright from everywhere.

    Of every rectangle four `vertices` (4 n, 3), counterclockwise, and their `texels` (4 n, 2) from the picture's top
    left corner, in parts of its size.
    """
    height, width = picture.shape[:2]
    texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, height=height, width=width, nchannel=3)
    texture.data = picture.tobytes()
    material = spec.add_material(name=name, emission=LIT, rgba=[1.0, 1.0, 1.0, 1.0])
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert, mesh.usertexcoord = np.ravel(vertices).tolist(), np.ravel(texels).tolist()
    first = 4 * np.arange(len(vertices) // 4)[:, None]
    mesh.userface = (first + np.array((0, 1, 2, 0, 2, 3))).ravel().tolist()
    shown = body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=name)
    shown.contype, shown.conaffinity, shown.mass = 0, 0, 0.0
    return shown
