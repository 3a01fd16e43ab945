"""An operator with a textured arm before one camera and a dark wall, which swings as in HAZEL-S, on and on."""

from collections.abc import Mapping
from itertools import cycle

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.hazel import FOREARM_M, PALM_POINT_M, SIZE_PX, Swing, TrueArm, film_pixel, hazel_film
from local_site.simulation.textured_arm import Scenery

JOINTS = ("shoulder", "elbow", "wrist")
FRAMES_PER_S = 30.0
LIVE_FINE = 1  # rendered while it is filmed, so that there is no time for finer pictures,
NOISES = 8  # nor for more noise than is made beforehand
SEED = 3
DARK_WALL, DARK_RELIEF = 20.0, 3.0  # so that its silhouette shows where it is


class TexturedOperator:
    """Stands still for `still_s`, then swings; the camera's frame is the operator's."""

    def __init__(self, still_s: float) -> None:
        self._film = hazel_film(Scenery(noise=0.0, wall=DARK_WALL, wall_relief=DARK_RELIEF), LIVE_FINE)
        random, (width, height) = np.random.default_rng(SEED), SIZE_PX
        noise = random.normal(0.0, Scenery().noise, (NOISES, height, width))
        self._noises = cycle(np.rint(noise).astype(np.int16))
        self._still_s = still_s
        self._swing = Swing()

    def render(self, t_s: float, cameras: tuple[int, ...] = (0,)) -> list[Image]:
        """The picture (H, W) grey with camera noise, once for each camera that is asked for."""
        clean = self._film.render(self._arm(t_s).limb_poses())
        return [np.asarray(cv2.add(clean, next(self._noises), dtype=cv2.CV_8U), dtype=np.uint8) for _ in cameras]

    def points(self, t_s: float) -> Mapping[str, Array]:
        """The points to be found at this time."""
        return true_points(self._arm(t_s))

    def openings_until(self, t_s: float) -> int:
        """Its hand never opens."""
        del t_s
        return 0

    def _arm(self, t_s: float) -> TrueArm:
        return self._swing.arm(FRAMES_PER_S * max(t_s - self._still_s, 0.0))


def true_points(arm: TrueArm) -> Mapping[str, Array]:
    """What a tracker is to find of an arm, by name, (3,) in m."""
    return {"elbow": arm.elbow, "wrist": arm.wrist, "palm": arm.along_forearm(FOREARM_M + PALM_POINT_M)}


def first_joints_px() -> Mapping[str, tuple[float, float]]:
    """Where the joints are in the first picture, px: what a person would click."""
    arm = Swing().arm(0.0)
    return {name: film_pixel(point) for name, point in zip(JOINTS, (arm.shoulder, arm.elbow, arm.wrist), strict=True)}
