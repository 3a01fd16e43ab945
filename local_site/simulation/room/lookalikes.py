"""Things that only look like skin or a hand: boards of wood in skin's colours, a poster of a hand."""

import numpy as np

from common.cameras.camera import Image
from local_site.simulation.body import ArmBody, BodyPose
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.config import BodyConfig
from local_site.simulation.room.arm import Arm
from local_site.simulation.room.config import RoomConfig
from local_site.simulation.room.lamps import office_lamps
from local_site.simulation.room.layer import Brush
from local_site.simulation.room.surroundings import PAPER, clouds, opaque

WOODS = ((112, 150, 198), (96, 132, 186), (124, 164, 210))  # blue, green, red
BOARD_M = 0.14
FULL_HAND_M = 0.34
FOCAL_PX_PER_PX = 3.0
PALM_TO_VIEWER = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])


def wood(random: np.random.Generator, px_per_m: float, width_m: float, height_m: float) -> Image:
    """Upright boards with grain, in the colours of skin."""
    shape = round(height_m * px_per_m), round(width_m * px_per_m)
    column = np.arange(shape[1])
    board = column // round(BOARD_M * px_per_m)
    shades = np.array(WOODS)[random.integers(len(WOODS), size=board.max() + 1)] * random.uniform(
        0.86, 1.04, (board.max() + 1, 1)
    )
    grain = clouds(random, (shape[0] // 16 + 1, shape[1]), 4.0).repeat(16, axis=0)[: shape[0]]
    level = 1.0 + 0.05 * grain + 0.03 * clouds(random, shape, 60.0)
    level[:, column % round(BOARD_M * px_per_m) < 2] *= 0.6
    return opaque(level[:, :, None] * shades[board])


def hand_poster(random: np.random.Generator, width: int) -> Image:
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
    Brush(camera, office_lamps(camera), (width, height), 0.6).draw(sheet, [arm.posed(raised)])
    return sheet
