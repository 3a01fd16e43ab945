"""The textured arm handles a flask on a table before a bookshelf, frame by frame: HAZEL-A and -B of the report."""

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np

from common.geometry import Array, rotation_from_vector
from local_site.simulation.hazel import (
    FOCAL_PX,
    FOREARM,
    FOREARM_M,
    PALM_POINT_M,
    PRINCIPAL_PX,
    SIZE_PX,
    UPPER_ARM,
    TrueArm,
    reaching_arm,
)
from local_site.simulation.textured_arm import ArmFilm, LimbPose, Picture, Scenery, TexturedLimb

HANDLING_FRAMES = 200
SHOULDER = np.array([-0.26, -0.19, 1.36])
LEAN = 0.12  # of the palm's motion, with which the shoulder follows it
TABLE_Y = 0.21  # the table's height in the camera's frame, whose y points down, m
FLASK_RADIUS_M, FLASK_HALF_M = 0.030, 0.080
FLASK_IN_PALM = np.array([0.0, 0.0, 0.045])  # on the palm's side of the hand, which the camera does not see
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # its z up the columns of the picture
GRASPING_Y = TABLE_Y - FLASK_HALF_M
FLASK_LEVEL = 190.0
FLASK = TexturedLimb(
    along=(-FLASK_HALF_M, 0.4 * FLASK_HALF_M, 0.7 * FLASK_HALF_M, FLASK_HALF_M),
    across=(FLASK_RADIUS_M, FLASK_RADIUS_M, 0.4 * FLASK_RADIUS_M, 0.4 * FLASK_RADIUS_M),
    deep=(FLASK_RADIUS_M, FLASK_RADIUS_M, 0.4 * FLASK_RADIUS_M, 0.4 * FLASK_RADIUS_M),
    level=FLASK_LEVEL,
)
TABLE_END_M = 1.75  # how far away the table ends
SHELF_PX, BOARD_PX = 84, 8
BOOK_PX, BOOK_LEVELS = (8, 26), (35.0, 200.0)
BOARD_LEVEL, GAP_LEVEL, TABLE_LEVEL = 110.0, 25.0, 95.0
GRAIN, OUT_OF_FOCUS_PX = 6.0, 0.8


@dataclass(frozen=True, slots=True)
class PalmStop:
    """The pose of a resting palm: its position (3,) in m, and how far the forearm is turned about its axis, rad."""

    palm: tuple[float, float, float]
    roll: float = 0.0


@dataclass(frozen=True, slots=True)
class Handling:
    """An arm that reaches, grasps, carries, sets down: its palm's stops by frame, and from when to when it holds.

    Between two stops the palm moves along a line with minimum jerk.
    """

    stops: Mapping[int, PalmStop]
    grasped: int
    released: int

    def arm(self, frame: float) -> TrueArm:
        """The arm at a frame; at frame 0 both links are parallel to the picture."""
        palm, roll = self._palm_and_roll(frame)
        shoulder = SHOULDER + LEAN * (palm - self._palm_and_roll(0.0)[0])
        arm = reaching_arm(shoulder, palm, FOREARM_M + PALM_POINT_M)
        return replace(arm, forearm=arm.forearm @ rotation_from_vector(np.array([0.0, 0.0, roll])))

    def flask(self, frame: float) -> LimbPose:
        """The pose of the flask, which stays upright in the hand."""
        palm, _ = self._palm_and_roll(min(max(frame, self.grasped), self.released))
        return LimbPose(palm + FLASK_IN_PALM, UPRIGHT)

    def limb_poses(self, frame: float) -> tuple[LimbPose, ...]:
        """The poses of upper arm, forearm and flask, for rendering."""
        return (*self.arm(frame).limb_poses(), self.flask(frame))

    def _palm_and_roll(self, frame: float) -> tuple[Array, float]:
        frames = list(self.stops)
        before = min(max(bisect_right(frames, frame) - 1, 0), len(frames) - 2)
        first, last = frames[before], frames[before + 1]
        s = min(max((frame - first) / (last - first), 0.0), 1.0)
        done = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        a, b = self.stops[first], self.stops[last]
        palm: Array = (1.0 - done) * np.array(a.palm) + done * np.array(b.palm)
        return palm, (1.0 - done) * a.roll + done * b.roll


GRASPING = Handling(
    stops={
        0: PalmStop((0.10, 0.00, 1.36)),
        10: PalmStop((0.10, 0.00, 1.36)),
        60: PalmStop((0.18, GRASPING_Y, 1.41), 0.25),
        75: PalmStop((0.18, GRASPING_Y, 1.41), 0.25),
        116: PalmStop((0.15, -0.05, 1.37), 0.1),
        160: PalmStop((0.10, 0.02, 1.46), 0.1),
        185: PalmStop((0.15, 0.00, 1.42)),
        199: PalmStop((0.15, 0.00, 1.42)),
    },
    grasped=70,
    released=199,
)
MOVING = Handling(
    stops={
        0: PalmStop((0.08, 0.00, 1.36)),
        8: PalmStop((0.08, 0.00, 1.36)),
        45: PalmStop((0.14, GRASPING_Y, 1.32), 0.2),
        58: PalmStop((0.14, GRASPING_Y, 1.32), 0.2),
        90: PalmStop((0.12, 0.00, 1.36), 0.1),
        112: PalmStop((0.14, 0.00, 1.45), 0.1),
        140: PalmStop((0.16, GRASPING_Y, 1.47), 0.2),
        154: PalmStop((0.16, GRASPING_Y, 1.47), 0.2),
        184: PalmStop((0.10, 0.02, 1.40)),
        199: PalmStop((0.10, 0.02, 1.40)),
    },
    grasped=54,
    released=148,
)


def grasping_film(scenery: Scenery | None = None) -> ArmFilm:
    """The film of upper arm, forearm and flask before the bookshelf, which is drawn from the scenery's seed."""
    scenery = scenery or Scenery()
    behind = bookshelf(np.random.default_rng(scenery.seed))
    return ArmFilm((UPPER_ARM, FOREARM, FLASK), FOCAL_PX, SIZE_PX, scenery, behind=behind)


def bookshelf(random: np.random.Generator) -> Picture:
    """Rows of books (H, W) in grey levels, in parts as bright as skin, above a table."""
    width, height = SIZE_PX
    picture = np.full((height, width), GAP_LEVEL, np.float32)
    for top in range(0, height, SHELF_PX):
        _books(picture[top : top + SHELF_PX - BOARD_PX], random)
        picture[top + SHELF_PX - BOARD_PX : top + SHELF_PX] = BOARD_LEVEL
    picture[round(PRINCIPAL_PX[1] + FOCAL_PX * TABLE_Y / TABLE_END_M) :] = TABLE_LEVEL
    picture += random.normal(0.0, GRAIN, picture.shape).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), OUT_OF_FOCUS_PX), np.float32).clip(0, 255)


def _books(shelf: Picture, random: np.random.Generator) -> None:
    """Fill a shelf (H, W) with books of all widths, heights and levels, a dark gap between them."""
    height, width = shelf.shape
    left = 0
    while left < width:
        right = left + int(random.integers(*BOOK_PX))
        shelf[int(random.uniform(0.0, 0.35) * height) :, left : right - 1] = random.uniform(*BOOK_LEVELS)
        left = right
