"""A textured arm's exact motions, as HAZEL-S and HAZEL-C of the ROBONAUT report, and an operator who makes them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import cycle

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array, rotation_from_vector
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.simulation.textured_arm import FINE, ArmFilm, LimbPose, Scenery, TexturedLimb

FOCAL_PX, SIZE_PX = 655.0, (640, 480)  # a 9 mm lens before a 2/3" chip
PRINCIPAL_PX = ((SIZE_PX[0] - 1) / 2, (SIZE_PX[1] - 1) / 2)
UPPER_ARM_M, FOREARM_M, PALM_M, FINGER_M = 0.300, 0.255, 0.095, 0.080
PALM_POINT_M = 0.060  # beyond the wrist: the point of the palm that is reported
UPPER_ARM = TexturedLimb((0.0, 0.150, 0.300), (0.0493, 0.0454, 0.0390), (0.0493, 0.0454, 0.0390))
FOREARM = TexturedLimb(
    along=(0.0, 0.064, 0.255, 0.312, 0.350),
    across=(0.0390, 0.0414, 0.0271, 0.0410, 0.0369),
    deep=(0.0390, 0.0414, 0.0271, 0.0150, 0.0120),
)
FINGER = TexturedLimb((0.0, 0.040, 0.075), (0.009, 0.008, 0.006), (0.009, 0.008, 0.006))
# The link's z along the picture's rows, its x down them, its y away from the camera.
FLAT = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
HAZEL_S_FRAMES, HAZEL_C_FRAMES = 400, 354
RAMP_FRAMES = 25.0
RECTANGLE_M, RECTANGLE_TURN = (0.22, 0.15), math.radians(-20.0)
CORNER = np.array([0.06, 0.10, 1.30])
SEATED_SHOULDER = np.array([-0.35, -0.22, 1.30])
JOINTS = ("shoulder", "elbow", "wrist")
FRAMES_PER_S = 30.0
LIVE_FINE = 1  # rendered live, which leaves no time for finer pictures
NOISES = 8  # made beforehand for the same reason
SEED = 3
DARK_WALL, DARK_RELIEF = 20.0, 3.0  # so that the arm's silhouette stands out


@dataclass(frozen=True, slots=True)
class TrueArm:
    """The arm at one frame in the camera's frame: shoulder (3,) in m, `camera_R_link` (3, 3) of both links."""

    shoulder: Array
    upper_arm: Array
    forearm: Array

    @property
    def elbow(self) -> Array:
        """The elbow (3,), m."""
        return self.shoulder + UPPER_ARM_M * self.upper_arm[:, 2]

    @property
    def wrist(self) -> Array:
        """The wrist (3,), m."""
        return self.along_forearm(FOREARM_M)

    def along_forearm(self, distance: float) -> Array:
        """The point (3,) on the forearm's axis at a distance from the elbow, m."""
        return self.elbow + distance * self.forearm[:, 2]

    def limb_poses(self) -> tuple[LimbPose, LimbPose]:
        """The poses of the two limbs, for rendering."""
        return LimbPose(self.shoulder, self.upper_arm), LimbPose(self.elbow, self.forearm)


@dataclass(frozen=True, slots=True)
class Swing:
    """The swing of HAZEL-S's arm: the shoulder's path in m, the links' turns in rad.

    `speed` is a factor on the report's; `in_plane` an added turn of the whole arm in the picture, rad.
    """

    shoulder_m: float = 0.0505
    upper_arm: float = 0.48
    forearm: float = 0.53
    speed: float = 1.0
    in_plane: float = 0.0

    def arm(self, frame: float) -> TrueArm:
        """The arm at a frame; at frame 0 both links are parallel to the picture."""
        k = self.speed * frame
        ramp = min(k / RAMP_FRAMES, 1.0) ** 2 * (3.0 - 2.0 * min(k / RAMP_FRAMES, 1.0))
        sway = ramp * self.shoulder_m * np.array([_wave(k, 97.0), 0.6 * _wave(k, 81.0), 0.8 * _wave(k, 113.0)])
        upper, lower = ramp * self.upper_arm, ramp * self.forearm
        upper_arm = link(0.75 + upper * _wave(k, 101.0), 0.6 * upper * _wave(k, 113.0), 0.5 * upper * _wave(k, 89.0))
        forearm = link(-0.1 + lower * _wave(k, 107.0), 0.5 * lower * _wave(k, 99.0), 0.5 * lower * _wave(k, 73.0))
        in_plane = self.in_plane * (0.5 - 0.5 * math.cos(math.pi * min(frame / HAZEL_S_FRAMES, 1.0)))
        turn = rotation_from_vector(np.array([0.0, 0.0, in_plane]))
        return TrueArm(turn @ (np.array([-0.26, -0.19, 1.36]) + sway), turn @ upper_arm, turn @ forearm)


def link(in_plane: float, out_of_plane: float, roll: float) -> Array:
    """`camera_R_link` of a link by its turns in rad: in the picture, out of it, and about itself."""
    turns = [rotation_from_vector(np.array(v)) for v in ((0.0, 0.0, in_plane), (0.0, out_of_plane, 0.0))]
    result: Array = turns[0] @ turns[1] @ FLAT @ rotation_from_vector(np.array([0.0, 0.0, roll]))
    return result


def rectangle_tip(frame: float) -> Array:
    """Return where the finger tip is on its rectangle (3,) in m, once round in all frames; it slows down at corners."""
    quarter, fraction = divmod(4.0 * frame / HAZEL_C_FRAMES % 4.0, 1.0)
    ease = 0.5 - 0.5 * math.cos(math.pi * fraction)
    a, b = [((0, 0), (1, 0)), ((1, 0), (1, 1)), ((1, 1), (0, 1)), ((0, 1), (0, 0))][int(quarter)]
    x, y = (RECTANGLE_M[i] * ((1.0 - ease) * a[i] + ease * b[i]) for i in range(2))
    tip: Array = CORNER + np.array([x * math.cos(RECTANGLE_TURN), -y, x * math.sin(RECTANGLE_TURN)])
    return tip


def pointing_arm(frame: float) -> TrueArm:
    """The arm of HAZEL-C, whose finger tip follows the rectangle while the shoulder sways a little."""
    sway = 0.008 * np.array([_wave(frame, 120.0), _wave(frame, 150.0), _wave(frame, 90.0)])
    return reaching_arm(SEATED_SHOULDER + sway, rectangle_tip(frame), FOREARM_M + PALM_M + FINGER_M)


def reaching_arm(shoulder: Array, point: Array, beyond_elbow: float) -> TrueArm:
    """The arm from a shoulder (3,) to a point (3,) on the forearm's axis, which is `beyond_elbow` m from the elbow.

    The elbow hangs as deep as it can. The point has to be in reach.
    """
    reach = point - shoulder
    distance = float(np.linalg.norm(reach))
    ahead = reach / distance
    along = (UPPER_ARM_M**2 - beyond_elbow**2 + distance**2) / (2.0 * distance)
    away = np.array([0.0, 0.0, 1.0]) - ahead[2] * ahead
    down = np.cross(away / np.linalg.norm(away), ahead)
    elbow = shoulder + along * ahead + math.sqrt(UPPER_ARM_M**2 - along**2) * down
    return TrueArm(shoulder, _along(elbow - shoulder), _along(point - elbow))


def hazel_film(scenery: Scenery | None = None, fine: int = FINE) -> ArmFilm:
    """The film of both limbs, rendered `fine` times finer than its pixels."""
    return ArmFilm((UPPER_ARM, FOREARM), FOCAL_PX, SIZE_PX, scenery, fine)


def pointing_film(scenery: Scenery | None = None) -> ArmFilm:
    """The film of an arm with a stretched finger, which belongs to the forearm."""
    beyond = replace(FINGER, along=tuple(FOREARM_M + PALM_M + z for z in FINGER.along))
    return ArmFilm((UPPER_ARM, FOREARM, beyond), FOCAL_PX, SIZE_PX, scenery)


def film_camera() -> Rig:
    """The film's camera, whose frame is the operator's too."""
    u, v = PRINCIPAL_PX
    rows = (FOCAL_PX, 0.0, u, 0.0), (0.0, FOCAL_PX, v, 0.0), (0.0, 0.0, 1.0, 0.0)
    camera = CameraCalibration("left", rows, 0.0, size_px=SIZE_PX)
    return Rig((camera,), (-1.0, -1.0, 0.5), (1.0, 1.0, 2.0), (0.0, 0.0, 0.0), "exact, simulated")


def film_pixel(point: Array) -> tuple[float, float]:
    """Project a point (3,) in m into the film's picture, px."""
    x, y, z = (float(value) for value in point)
    return FOCAL_PX * x / z + PRINCIPAL_PX[0], FOCAL_PX * y / z + PRINCIPAL_PX[1]


class TexturedOperator:
    """Keeps still for `still_s`, then swings; the camera's frame is the operator's."""

    def __init__(self, still_s: float) -> None:
        self._film = hazel_film(Scenery(noise=0.0, wall=DARK_WALL, wall_relief=DARK_RELIEF), LIVE_FINE)
        random, (width, height) = np.random.default_rng(SEED), SIZE_PX
        noise = random.normal(0.0, Scenery().noise, (NOISES, height, width))
        self._noises = cycle(np.rint(noise).astype(np.int16))
        self._still_s = still_s
        self._swing = Swing()

    def render(self, t_s: float, cameras: tuple[int, ...] = (0,), filmed_s: float | None = None) -> list[Image]:
        """The picture (H, W) grey with camera noise, once for each camera that is asked for."""
        del filmed_s
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
    """Return what a tracker is to find of an arm, by name, (3,) in m."""
    return {"elbow": arm.elbow, "wrist": arm.wrist, "palm": arm.along_forearm(FOREARM_M + PALM_POINT_M)}


def first_joints_px() -> Mapping[str, tuple[float, float]]:
    """Return where the joints are in the first picture, px: what a person would click."""
    arm = Swing().arm(0.0)
    return {name: film_pixel(point) for name, point in zip(JOINTS, (arm.shoulder, arm.elbow, arm.wrist), strict=True)}


def _wave(frame: float, period: float) -> float:
    return math.sin(2.0 * math.pi * frame / period)


def _along(direction: Array) -> Array:
    """`camera_R_link` of a link along a direction (3,), its palm flat before the camera as far as that goes."""
    z = direction / np.linalg.norm(direction)
    y = np.array([0.0, 0.0, 1.0]) - z[2] * z
    y /= np.linalg.norm(y)
    return np.column_stack([np.cross(y, z), y, z])
