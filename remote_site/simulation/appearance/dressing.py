"""Dresses the cell for the views: textured room, furniture and table around what moves, which keeps its plain paint."""

from collections.abc import Sequence

import cv2
import mujoco
import numpy as np

from common.geometry import Array
from remote_site.simulation.appearance.furniture import furniture
from remote_site.simulation.appearance.light import lamp_points
from remote_site.simulation.appearance.materials import Picture
from remote_site.simulation.appearance.room import HEIGHT_M, painted_room
from remote_site.simulation.appearance.surfaces import PaintedSurface, Rectangle, box_corners
from remote_site.simulation.appearance.worktable import painted_table
from remote_site.simulation.config import SceneConfig
from remote_site.simulation.scenery import ROOM_GROUP, TABLE_THICKNESS_M

SEED = 465
GUTTER_PX = 3
ATLAS_WIDTH_PX = 1400
LIT = 1.0  # emission that outshines every light: what is baked into the texture is all that is seen
UNSEEN = (0.0, 0.0, 0.0, 0.0)


def dress(spec: mujoco.MjSpec, scene: SceneConfig) -> tuple[PaintedSurface, ...]:
    """Put furniture around the cell and return the surfaces of room and table.

    The same cell always looks the same. Nothing that is added can be touched. Furniture is of `ROOM_GROUP`. What moves
    keeps its plain paint: textures on it would take the software renderer longer than all the rest of a view.
    """
    rng = np.random.default_rng(SEED)
    aim = np.array([*scene.table_centre_xy_m, scene.table_z_m])
    lamp = lamp_points(aim, scene.floor_z_m + HEIGHT_M - 0.1)
    pieces, table = furniture(), _table_boxes(scene)
    around = [piece.corners(scene.floor_z_m) for piece in pieces]
    spec.geom("floor").rgba = UNSEEN
    faces = [face for piece in pieces for face in piece.faces(rng, scene.floor_z_m)]
    _add_pictured(spec, "furniture", faces)
    size = (*scene.table_size_xy_m, TABLE_THICKNESS_M)
    room = painted_room(rng, scene.floor_z_m, [*around, *table], lamp, aim)
    return (*room, *painted_table(rng, aim, size, around, lamp))


def _table_boxes(scene: SceneConfig) -> list[Array]:
    """Build the boxes that throw shadows beside the furniture: the table's top, its legs, the pedestal."""
    (x, y), (length, width), floor = scene.table_centre_xy_m, scene.table_size_xy_m, scene.floor_z_m
    half, under = scene.pedestal_side_m / 2, scene.table_z_m - TABLE_THICKNESS_M

    def box(low: Sequence[float], high: Sequence[float]) -> Array:
        return box_corners(np.array(low), np.array(high))

    boxes = [box((-half, -half, floor), (half, half, 0.0))]
    boxes.append(box((x - length / 2, y - width / 2, under), (x + length / 2, y + width / 2, scene.table_z_m)))
    for side in (-1, 1):
        for end in (-1, 1):
            leg_x, leg_y = x + end * (length / 2 - 0.04), y + side * (width / 2 - 0.04)
            boxes.append(box((leg_x - 0.02, leg_y - 0.02, floor), (leg_x + 0.02, leg_y + 0.02, under)))
    return boxes


def _add_pictured(spec: mujoco.MjSpec, name: str, faces: Sequence[tuple[Rectangle, Picture]]) -> None:
    """Show rectangles with their pictures through one mesh with one texture."""
    atlas, places = _packed([picture for _, picture in faces])
    _add_material(spec, name, atlas)
    height, width = atlas.shape[:2]
    vertices, texels = [], []
    for (rectangle, picture), (top, left) in zip(faces, places, strict=True):
        rows, columns = picture.shape[:2]
        low, right, up = rectangle.corner, rectangle.right, rectangle.up
        vertices += [low, low + right, low + right + up, low + up]
        u, v = (left / width, (left + columns) / width), (top / height, (top + rows) / height)
        texels += [(u[0], v[1]), (u[1], v[1]), (u[1], v[0]), (u[0], v[0])]
    first = 4 * np.arange(len(faces))[:, None]
    triangles = first + np.array((0, 1, 2, 0, 2, 3))
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert, mesh.usertexcoord = np.ravel(vertices).tolist(), np.ravel(texels).tolist()
    mesh.userface = triangles.ravel().tolist()
    shown = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=name)
    shown.contype, shown.conaffinity, shown.mass, shown.group = 0, 0, 0.0, ROOM_GROUP


def _add_material(spec: mujoco.MjSpec, name: str, picture: Picture) -> None:
    height, width = picture.shape[:2]
    kind = mujoco.mjtTexture.mjTEXTURE_2D
    texture = spec.add_texture(name=name, type=kind, height=height, width=width, nchannel=3)
    texture.data = np.rint(255.0 * picture).astype(np.uint8).tobytes()
    material = spec.add_material(name=name, emission=LIT, rgba=[1.0, 1.0, 1.0, 1.0])
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name


def _packed(pictures: Sequence[Picture]) -> tuple[Picture, list[tuple[int, int]]]:
    """All pictures side by side in rows, each with a margin of its own edge, and where (top, left) each lies."""
    places = [(0, 0)] * len(pictures)
    top = left = tall = 0
    for k in sorted(range(len(pictures)), key=lambda k: -pictures[k].shape[0]):
        height, width = (size + 2 * GUTTER_PX for size in pictures[k].shape[:2])
        if left + width > ATLAS_WIDTH_PX:
            top, left, tall = top + tall, 0, 0
        places[k] = (top + GUTTER_PX, left + GUTTER_PX)
        left, tall = left + width, max(tall, height)
    atlas = np.zeros((top + tall, ATLAS_WIDTH_PX, 3), dtype=np.float32)
    for picture, (row, column) in zip(pictures, places, strict=True):
        padded = cv2.copyMakeBorder(picture, *(GUTTER_PX,) * 4, cv2.BORDER_REPLICATE)
        atlas[row - GUTTER_PX :, column - GUTTER_PX :][: padded.shape[0], : padded.shape[1]] = padded
    return atlas, places
