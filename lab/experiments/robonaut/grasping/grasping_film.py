"""The film of an arm and a flask on a table before a bookshelf; the shelf is drawn from the scenery's seed."""

import cv2
import numpy as np

from lab.experiments.robonaut.grasping.handling import FLASK_HALF_M, FLASK_RADIUS_M, TABLE_Y
from local_site.simulation.hazel import FOCAL_PX, FOREARM, PRINCIPAL_PX, SIZE_PX, UPPER_ARM
from local_site.simulation.textured_arm import ArmFilm, Picture, Scenery, TexturedLimb

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


def grasping_film(scenery: Scenery | None = None) -> ArmFilm:
    """The film of upper arm, forearm and flask before the bookshelf."""
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
