"""A bare arm drawn before two cameras: pictures in colour, the mask of its skin, and the hand as landmarks give it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import focal_length, project
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.foreground.growing import FINGERS, PALM
from local_site.tracking.landmarks.crop import Crop
from local_site.tracking.landmarks.hand_landmarks import HandLandmarks
from local_site.tracking.landmarks.hand_pairing import SeenHand

Colour = tuple[float, float, float]
SKIN: Colour = (95.0, 135.0, 190.0)
CLOTH: Colour = (90.0, 70.0, 50.0)
SIZE = (480, 640)
SHARES = (0.25, 0.5, 0.7, 0.85, 1.0)  # of a finger's length, joint by joint
_JOINTS = SimulatedOperator(SimulationConfig()).truth(0.0)
ACROSS_M = (0.045, 0.028, 0.008, -0.012, -0.03)


def rig() -> Rig:
    """The simulated cameras, exactly calibrated."""
    return exact_rig(StereoConfig())


@dataclass(frozen=True)
class DrawnArm:
    """An arm moved by `shift` (3,) in m, with a sleeve from the wrist or the elbow on, and maybe a band."""

    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    long_sleeve: bool = False
    band: bool = False
    skin: Colour = SKIN

    @property
    def wrist(self) -> Array:
        """The wrist (3,) in m."""
        result: Array = _JOINTS.wrist + self.shift
        return result

    @property
    def elbow(self) -> Array:
        """The elbow (3,) in m."""
        result: Array = _JOINTS.elbow + self.shift
        return result

    def hand(self) -> Array:
        """The hand's landmarks (21, 3) in m: flat, in the forearm's direction."""
        along = (self.wrist - self.elbow) / np.linalg.norm(self.wrist - self.elbow)
        side = np.cross(along, [0.0, 1.0, 0.0])
        side /= np.linalg.norm(side)
        points = [self.wrist]
        for across, length in zip(ACROSS_M, (0.11, 0.17, 0.18, 0.17, 0.15), strict=True):
            tip = length * along + 1.6 * across * side
            points += [self.wrist + share * tip for share in SHARES[1:]]
        return np.array(points)

    def seen(self, cameras: Rig) -> SeenHand:
        """The hand as it is found in all views."""
        points = self.hand()
        crop = Crop(np.zeros(2), 1.0, 0.0)
        pixels = {k: project(matrix, points) for k, matrix in enumerate(cameras.matrices)}
        views = {k: HandLandmarks(seen, 0.9, 0.9, crop) for k, seen in pixels.items()}
        return SeenHand(points, views, pixels, 0.0, 0.0)

    def draw(self, room: Image, projection: Array) -> tuple[Image, NDArray[np.uint8]]:
        """The arm before a room (H, W, 3), and the mask (H, W) of its bare skin, 1 on the arm."""
        shoulder = self.elbow + np.array([0.0, 0.05, -0.16])
        skin, cloth = np.zeros(SIZE, np.uint8), np.zeros(SIZE, np.uint8)
        _limb(skin, projection, self.elbow, shoulder, 0.042)
        _limb(skin, projection, self.wrist, self.elbow, 0.034)
        if self.long_sleeve:
            _limb(cloth, projection, self.wrist, self.elbow, 0.044)
            _limb(cloth, projection, self.elbow, shoulder, 0.048)
        if self.band:
            along = (self.elbow - self.wrist) / np.linalg.norm(self.elbow - self.wrist)
            ends = project(projection, np.array([self.wrist + 0.04 * along, self.wrist + 0.065 * along]))
            across = (ends[1] - ends[0])[::-1] * (-1.0, 1.0) / np.linalg.norm(ends[1] - ends[0])
            across *= 0.038 * _px_per_m(projection, self.wrist)
            corners = [ends[0] + across, ends[1] + across, ends[1] - across, ends[0] - across]
            cv2.fillConvexPoly(cloth, np.rint(corners).astype(np.int32), 1)
        pixels = project(projection, self.hand())
        thick = round(0.020 * _px_per_m(projection, self.wrist))
        for finger in FINGERS:
            cv2.polylines(skin, [np.rint(pixels[list(finger)]).astype(np.int32)], False, 1, thick)
        cv2.fillConvexPoly(skin, cv2.convexHull(np.rint(pixels[list(PALM)]).astype(np.int32)), 1)
        picture = _laid(_laid(room.astype(np.float32), skin, self.skin), cloth, CLOTH)
        return np.clip(picture, 0, 255).astype(np.uint8), skin | cloth if self.band else skin * (1 - cloth)


def shelf_room(seed: int) -> Image:
    """A room (H, W, 3) of boxes in colours without skin's, with noise."""
    random = np.random.default_rng(seed)
    picture = np.full((*SIZE, 3), 170, np.uint8)
    for _ in range(40):
        x, y = random.integers(0, 640), random.integers(0, 480)
        w, h = random.integers(20, 140, 2)
        b, g, r = random.uniform(20, 230), random.uniform(20, 230), random.uniform(20, 90)
        cv2.rectangle(picture, (int(x), int(y)), (int(x + w), int(y + h)), (b, g, r), cv2.FILLED)
    return noisy(np.asarray(cv2.GaussianBlur(picture, (0, 0), 1.0), np.uint8), random)


def noisy(picture: Image, random: np.random.Generator) -> Image:
    """The picture with a sensor's noise."""
    return np.clip(picture + random.normal(0.0, 3.0, picture.shape), 0, 255).astype(np.uint8)


def overlap(contour: Array, truth: NDArray[np.uint8]) -> float:
    """Intersection over union of an outline (N, 2) and a mask (H, W)."""
    found = np.zeros(truth.shape, np.uint8)
    cv2.drawContours(found, [contour.astype(np.int32)], -1, 1, cv2.FILLED)
    return float(np.count_nonzero(found & truth) / np.count_nonzero(found | truth))


def _laid(picture: Array, mask: NDArray[np.uint8], colour: Colour) -> Array:
    cover = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 0.7)[..., None]
    result: Array = (1.0 - cover) * picture + cover * np.array(colour, np.float32)
    return result


def _limb(mask: NDArray[np.uint8], projection: Array, start: Array, end: Array, half_width_m: float) -> None:
    a, b = project(projection, np.array([start, end]))
    cv2.line(mask, _px(a), _px(b), 1, round(2 * half_width_m * _px_per_m(projection, start)))


def _px_per_m(projection: Array, point: Array) -> float:
    return focal_length(projection) / float(projection[2, :3] @ point + projection[2, 3])


def _px(position: Array) -> tuple[int, int]:
    x, y = np.rint(position).astype(int).tolist()
    return x, y
