"""The rooms behind the arm: a wall and a desk, each a textured plane, drawn from a seed; what moves on the wall."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import cv2
import matplotlib as mpl
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.errors import CameraError
from lab.films.arm.arm_mesh import load_arm_mesh
from lab.films.arm.motions import WRIST, ArmMotion
from lab.films.arm.posing import PosedArm
from lab.films.arm.postures import posture_angles
from lab.films.arm.skin import arm_albedo
from lab.films.picture.light import Lighting, lit
from lab.films.picture.rendering import rendered
from lab.films.room import furniture
from local_site.calibration.physical_camera import Lens, PhysicalCamera
from local_site.simulation.room.panels import Plane
from local_site.simulation.room.scenery import ACROSS, DOWN, NEARER

RoomName = Literal["plain", "office", "wood", "photograph", "fan", "poster"]

WALL_SHAPE, DESK_SHAPE = (1600, 2600), (900, 1300)
WALL = Plane(480.0, np.array([-2.2, 1.75, 2.2]), ACROSS, DOWN)
DESK = Plane(480.0, np.array([-0.9, -0.5, 0.02]), ACROSS, -NEARER)  # its picture begins at the front
PHOTOGRAPH = Path(mpl.get_data_path()) / "sample_data" / "grace_hopper.jpg"  # public domain
SHADE_PX = 8  # of the wall, to one of a shade
FAN_AT, FAN_RADIUS = (1500, 560), 210
DISTANCE_M = 1.1
SIZE = (620, 500)
GROUND = (214, 222, 226)
BESIDE = np.array([-0.10, 0.0, 0.03])  # from the wrist to the middle of the portrait, m


def hand_portrait() -> Image:
    """The picture (H, W, 3), BGR."""
    mesh = load_arm_mesh("average")
    pose = ArmMotion("hold", mesh.upper_arm_m, mesh.forearm_m, np.radians(80.0), seed=0).pose(0.0)
    vertices = PosedArm(mesh).vertices(pose, posture_angles("open"))
    window = np.array([-0.5, -0.7, 0.5])
    lighting = Lighting(window / np.linalg.norm(window), np.array([0.6, -0.8, 0.0]))
    colours = lit(vertices, mesh.triangles, arm_albedo(mesh, "light", (60, 60, 80), seed=0), lighting)
    along_y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    stand = WRIST + BESIDE - np.array([0.0, DISTANCE_M, 0.0])
    camera = PhysicalCamera(Lens(1300.0, 1300.0, SIZE[0] / 2, SIZE[1] / 2), along_y, -along_y @ stand)
    picture = np.full((SIZE[1], SIZE[0], 3), GROUND, np.float32)
    layer = rendered(camera, SIZE, [vertices], mesh.triangles, colours)
    if layer is not None:
        layer.over(picture)
    return picture.astype(np.uint8)


@dataclass(frozen=True, slots=True)
class FurnishedRoom:
    """A wall and a desk (H, W, 3), BGR, and what moves by the time in s: it draws on a copy of the wall, or shades.

    The shade (h, w) is how much light is left, from 0 to 1, on the whole wall and as much on the desk.
    """

    wall: Image
    desk: Image
    moving: Callable[[Image, float], None] | None = None
    shade: Callable[[float], NDArray[np.float32]] | None = None


def furnished(name: RoomName, seed: int) -> FurnishedRoom:
    """A room of this kind, another for each seed."""
    random = np.random.default_rng(seed)
    return _ROOMS[name](random)


def _plain(random: Generator) -> FurnishedRoom:
    """A plain office: a painted wall with a door, a light desk."""
    wall = furniture.painted(WALL_SHAPE, (198, 206, 208), random)
    door = int(random.integers(150, 700))
    cv2.rectangle(wall, (door, 250), (door + 420, 1500), (170, 180, 186), -1)
    cv2.rectangle(wall, (door, 250), (door + 420, 1500), (120, 128, 132), 6)
    cv2.rectangle(wall, (0, 1250), (WALL_SHAPE[1], 1290), (160, 165, 170), -1)
    desk = furniture.painted(DESK_SHAPE, (206, 210, 212), random)
    furniture.clutter(desk, 3, random)
    return FurnishedRoom(wall, desk)


def _office(random: Generator) -> FurnishedRoom:
    """Shelves, screens, cables, and the light of a window."""
    wall = furniture.painted(WALL_SHAPE, (184, 192, 196), random)
    furniture.window(wall, int(random.integers(100, 500)), 150, 460, 560)
    furniture.shelf(wall, int(random.integers(1500, 1800)), 230, 620, 700, random)
    furniture.shelf(wall, int(random.integers(750, 900)), 120, 480, 420, random)
    for left in (620, 1250):
        furniture.monitor(wall, left + int(random.integers(0, 120)), 760 + int(random.integers(0, 120)), 480, random)
    furniture.cables(wall, 9, random)
    desk = furniture.wooden(DESK_SHAPE, random, (150, 176, 196))
    furniture.clutter(desk, 22, random)
    return FurnishedRoom(wall, desk)


def _wood(random: Generator) -> FurnishedRoom:
    """Wood of skin's colour everywhere, over which shadows move."""
    wall, desk = furniture.wooden(WALL_SHAPE, random), furniture.wooden(DESK_SHAPE, random)
    drifts = random.uniform(0.6, 1.4, (3, 2))

    def shade(t_s: float) -> NDArray[np.float32]:
        dark = np.zeros((WALL_SHAPE[0] // SHADE_PX, WALL_SHAPE[1] // SHADE_PX), np.float32)
        for k, (across, down) in enumerate(drifts):
            x = (0.3 + 0.2 * k + 0.12 * math.sin(across * t_s + k)) * dark.shape[1]
            y = (0.35 + 0.12 * math.sin(down * t_s + 2.0 * k)) * dark.shape[0]
            cv2.ellipse(dark, (round(x), round(y)), (26, 60), 20.0 * k, 0, 360, 1.0, -1)
        return np.asarray(1.0 - 0.45 * cv2.GaussianBlur(dark, (0, 0), 5.0), dtype=np.float32)

    return FurnishedRoom(wall, desk, shade=shade)


def _photograph(random: Generator) -> FurnishedRoom:
    """A photograph that fills the wall: cloth, a face and a flag."""
    read = cv2.imread(str(PHOTOGRAPH))
    if read is None:
        raise CameraError(f"cannot read {PHOTOGRAPH}: install matplotlib with its sample data")
    photograph: Image = np.asarray(read, dtype=np.uint8)
    wall = furniture.painted(WALL_SHAPE, (150, 160, 170), random)
    furniture.poster(wall, photograph, 780 + int(random.integers(0, 150)), 30, 1000)
    furniture.poster(wall, photograph[:, ::-1], 120, 300, 420)
    furniture.poster(wall, photograph, 2020, 420, 420)
    desk = furniture.painted(DESK_SHAPE, (90, 96, 104), random)
    furniture.clutter(desk, 8, random)
    return FurnishedRoom(wall, desk)


def _poster(random: Generator) -> FurnishedRoom:
    """The plain office, with a poster of a hand, larger than life."""
    plain = _plain(random)
    furniture.poster(plain.wall, hand_portrait(), 940 + int(random.integers(0, 80)), 560, 560)
    return plain


def _fan(random: Generator) -> FurnishedRoom:
    """The office, with a fan that turns."""
    office = _office(random)

    def blades(picture: Image, t_s: float) -> None:
        cv2.circle(picture, FAN_AT, FAN_RADIUS, (70, 72, 76), -1, cv2.LINE_AA)
        for k in range(3):
            turn = math.degrees(7.0 * t_s) + 120.0 * k
            cv2.ellipse(picture, FAN_AT, (FAN_RADIUS - 12, 150), 0, turn, turn + 62.0, (186, 190, 196), -1, cv2.LINE_AA)
        cv2.circle(picture, FAN_AT, 40, (40, 42, 46), -1, cv2.LINE_AA)

    return FurnishedRoom(office.wall, office.desk, blades)


_ROOMS: dict[RoomName, Callable[[Generator], FurnishedRoom]] = {
    "plain": _plain,
    "office": _office,
    "wood": _wood,
    "photograph": _photograph,
    "fan": _fan,
    "poster": _poster,
}
