"""Pictures of printed markers with known truth, as noisy cameras with known projections see them."""

import math
from collections.abc import Sequence

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array, transform
from common.messages.requests import ViewCalibration
from remote_site.assist.families import MarkerFamily
from remote_site.assist.placement import transform_of
from remote_site.simulation.views import OPENGL_R_IMAGE, look_at

SIZE = (480, 640)
FINER = 4  # pixels are averaged from so many rows and columns
FOCAL_PX = 800.0
LEVEL, NOISE = 150, 3.0
UP = np.array([0.0, 0.0, 1.0])
TARGET = np.array([0.5, 0.0, 0.7])
FACING = transform_of((500.0, 0.0, 700.0), (90.0, 0.0, 90.0))  # towards the cameras of FRONT, at +x
FRONT = {"front_high": (1.6, 0.45, 1.3), "front_low": (1.7, -0.4, 0.75)}


def calibration(position: Sequence[float], target: Array = TARGET, focal_px: float = FOCAL_PX) -> ViewCalibration:
    """A camera at a place (3,) that looks at another, m in the base's frame."""
    camera_R_base = (look_at(np.array(position), target, UP) @ OPENGL_R_IMAGE).T
    height, width = SIZE
    pixels = np.array([[focal_px, 0, width / 2], [0, focal_px, height / 2], [0, 0, 1]])
    moved = np.column_stack([camera_R_base, -camera_R_base @ np.array(position)])
    return ViewCalibration(tuple((pixels @ moved).ravel().tolist()), on_tool=False)


def picture(
    projection: Array, markers: Sequence[tuple[MarkerFamily, int, float, Array]], rng: np.random.Generator
) -> Image:
    """What a camera (3 x 4) sees of markers: family, number, side in m, pose `base_T_marker` (4 x 4) of each."""
    fine = np.full((SIZE[0] * FINER, SIZE[1] * FINER), LEVEL, dtype=np.uint8)
    for family, number, size_m, pose in markers:
        printed = family.printed(number, 20)
        half = size_m / 2 * len(printed) / (len(printed) - 40)
        square = np.array([(-half, half, 0, 1), (half, half, 0, 1), (half, -half, 0, 1), (-half, -half, 0, 1)])
        seen = square @ pose.T @ projection.T
        corners = (FINER * seen[:, :2] / seen[:, 2:] - 0.5).astype(np.float32)
        end = len(printed) - 0.5
        texels = np.array([(-0.5, -0.5), (end, -0.5), (end, end), (-0.5, end)], dtype=np.float32)
        warp = cv2.getPerspectiveTransform(texels, corners)
        shown = cv2.warpPerspective(printed, warp, fine.shape[::-1], flags=cv2.INTER_AREA)
        where = cv2.warpPerspective(np.full_like(printed, 255), warp, fine.shape[::-1])
        fine = np.where(where > 127, shown, fine)
    averaged = cv2.resize(fine, SIZE[::-1], interpolation=cv2.INTER_AREA).astype(float)
    noisy = cv2.GaussianBlur(averaged, (0, 0), 0.5) + rng.normal(0.0, NOISE, SIZE)
    return np.repeat(np.clip(noisy, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)


def turned(pose: Array, rpy_deg: tuple[float, float, float], by_m: tuple[float, float, float] = (0, 0, 0)) -> Array:
    """A pose (4 x 4) turned about its own axes, and moved in the base's frame."""
    moved = pose @ transform_of((0, 0, 0), rpy_deg)
    return transform(moved[:3, :3], moved[:3, 3] + by_m)


def miss(one: Array, other: Array) -> tuple[float, float]:
    """How far two poses (4 x 4) are apart, mm and deg."""
    cosine = (np.trace(one[:3, :3].T @ other[:3, :3]) - 1) / 2
    return 1e3 * math.dist(one[:3, 3], other[:3, 3]), math.degrees(math.acos(min(1.0, cosine)))
