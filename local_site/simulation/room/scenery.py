"""The office behind the operator, drawn from a random generator: what stands and hangs where."""

from collections.abc import Collection

import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.body import ArmBody, BodyPose
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.config import BodyConfig
from local_site.simulation.room import furniture, surroundings
from local_site.simulation.room.config import DisturbanceName, RoomConfig
from local_site.simulation.room.layer import Brush
from local_site.simulation.room.panels import Panel, Plane
from local_site.simulation.room.person import Arm
from local_site.simulation.room.surroundings import PAPER, opaque

WALL_Y, FLOOR_Z = 2.6, -0.80
WALL_X, WALL_TOP_Z, WALL_WIDTH = -3.4, 1.5, 8.0
DESK_Y, DESK_DEEP, DESK_Z = 1.75, 0.75, -0.06
ACROSS, DOWN, NEARER = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0]), np.array([0.0, -1.0, 0.0])
PX_PER_M, FLOOR_PX_PER_M = 320.0, 150.0
POSTER_M, FULL_HAND_M = 0.42, 0.34
FOCAL_PX_PER_PX = 3.0
PALM_TO_VIEWER = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])


def office(random: np.random.Generator, also: Collection[DisturbanceName] = ()) -> list[Panel]:
    """Build what stands in it, the farthest first; `also` wood and the poster of a hand, which are part of it."""
    floor = surroundings.floor(random, FLOOR_PX_PER_M, WALL_WIDTH, WALL_Y + 1.0)
    wall = surroundings.wall(random, PX_PER_M, WALL_WIDTH, WALL_TOP_Z - FLOOR_Z)
    panels = [
        Panel(floor, Plane(FLOOR_PX_PER_M, np.array([WALL_X, WALL_Y, FLOOR_Z]), ACROSS, NEARER)),
        _panel(wall, (WALL_X, WALL_Y, WALL_TOP_Z), DOWN),
    ]
    side = float(random.choice([-1.0, 1.0]))
    shelf_x = 0.25 - 1.05 * side + random.uniform(-0.1, 0.1)
    shelf = furniture.shelf(random, PX_PER_M, 1.0, 0.75)
    panels.append(_panel(shelf, (shelf_x - 0.5, WALL_Y - 0.25, 0.95 + random.uniform(-0.1, 0.1)), DOWN))
    cupboard = furniture.cupboard(random, PX_PER_M, 0.9, 0.78)
    panels.append(_panel(cupboard, (shelf_x - 0.5, WALL_Y - 0.4, FLOOR_Z + 0.78), DOWN))
    return panels + _lookalikes(random, also) + _desk(random, 0.35 + 0.75 * side + random.uniform(-0.1, 0.1))


def _lookalikes(random: np.random.Generator, also: Collection[DisturbanceName]) -> list[Panel]:
    """Wood behind the operator's hand, and a poster of a hand."""
    panels = []
    if "wood" in also:
        boards = surroundings.wood(random, PX_PER_M, 1.5, 2.0)
        panels.append(_panel(boards, (-0.3, WALL_Y - 0.45, FLOOR_Z + 2.0), DOWN))
    if "hand_poster" in also:
        sheet = opaque(_hand_poster(random, round(POSTER_M * PX_PER_M)))
        panels.append(_panel(sheet, (0.72, WALL_Y - 0.46, 0.86), DOWN))
    return panels


def _hand_poster(random: np.random.Generator, width: int) -> Image:
    """A sheet (H, W, 3) with the picture of a raised hand."""
    height = round(1.3 * width)
    sheet = np.full((height, width, 3), PAPER, np.uint8)
    focal = FOCAL_PX_PER_PX * width
    camera = PinholeCamera(
        camera_R_operator=np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
        centre=np.array([0.0, -FULL_HAND_M * FOCAL_PX_PER_PX, 0.06]),
        focal_px=focal,
        principal_px=np.array([width / 2, height / 2]),
        k1=0.0,
    )
    arm = Arm(ArmBody(BodyConfig()), RoomConfig(scene="office", skin="light"), random)
    raised = BodyPose(np.array([0.1, 0.3, -0.5]), np.array([0.02, 0.05, -0.28]), np.zeros(3), PALM_TO_VIEWER, 1.0)
    Brush(camera, (width, height), 0.6).draw(sheet, [arm.posed(raised)])
    return sheet


def _desk(random: np.random.Generator, middle_x: float) -> list[Panel]:
    """A desk with what lies and stands on it."""
    left, back = middle_x - 0.8, DESK_Y + DESK_DEEP
    top = furniture.desk_top(random, PX_PER_M, 1.6, DESK_DEEP)
    panels = [
        _panel(furniture.drawers(random, PX_PER_M, 0.42, 0.70), (left + 1.1, DESK_Y + 0.05, DESK_Z - 0.03), DOWN),
        _panel(furniture.legs(PX_PER_M, 1.6, DESK_Z - FLOOR_Z), (left, DESK_Y + 0.02, DESK_Z), DOWN),
        _panel(top, (left, back, DESK_Z), NEARER),
    ]
    screen_x = middle_x + random.uniform(-0.25, 0.05)
    monitor = furniture.monitor(random, PX_PER_M, 0.56, 0.48)
    panels.append(_panel(monitor, (screen_x - 0.28, back - 0.2, DESK_Z + 0.48), DOWN))
    for x, thing in ((-0.72, furniture.books), (0.48, furniture.plant), (0.34, furniture.mug)):
        picture = thing(random, PX_PER_M)
        corner = middle_x + x, back - 0.3 - random.uniform(0.0, 0.15), DESK_Z + picture.shape[0] / PX_PER_M
        panels.append(_panel(picture, corner, DOWN))
    return panels


def _panel(picture: Image, corner: tuple[float, float, float], down: Array) -> Panel:
    return Panel(picture, Plane(PX_PER_M, np.array(corner), ACROSS, down))
