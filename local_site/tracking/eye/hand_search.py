"""Where a hand is at all: whole pictures are searched, and two views that find one in the same place give a start."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.calibration.triangulation import image_of, triangulate
from local_site.tracking.eye.arm_points import ELBOW, POINTS, WRIST
from local_site.tracking.eye.crops import in_colour
from local_site.tracking.eye.networks import EyeNetworks, sigmoid

WIDTH, HEIGHT, CELL_PX = 192, 144, 4
SURE, MOST_HANDS = 0.1, 4
MOST_OFF = 0.35  # of 0.1 m in the picture: how far two views may miss each other
OTHER_SIZE = 1.8  # times: a hand of another size than its distance says is another hand
HALF_PALM_M, FOREARM_M = 0.05, 0.25
UNIT_M = 0.1


@dataclass(frozen=True, slots=True)
class FoundHand:
    """A hand that a picture may show: its palm's middle (2,) and direction (2,), undistorted px, 0.1 m in px, score."""

    middle: Array
    direction: Array
    unit_px: float
    score: float


class HandSearch:
    """Searches all views for hands that two of them agree on."""

    def __init__(self, rig: Rig, networks: EyeNetworks) -> None:
        self._rig, self._networks = rig, networks

    def starts(self, pictures: Sequence[Image]) -> list[Array]:
        """Find points (22, 3) in m of hands, held flat and the arm straight, to start looking from; the best first."""
        found = [self._found(camera, picture) for camera, picture in zip(self._rig.cameras, pictures, strict=True)]
        starts = []
        for i, j in combinations(range(len(found)), 2):
            for one in found[i]:
                for other in found[j]:
                    start = self._start((i, j), (one, other))
                    if start is not None:
                        starts.append((one.score * other.score, start))
        return [points for _, points in sorted(starts, key=lambda scored: -scored[0])]

    def _found(self, camera: CameraCalibration, picture: Image) -> list[FoundHand]:
        scale = min(WIDTH / picture.shape[1], HEIGHT / picture.shape[0])
        small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        colour = in_colour(np.asarray(small, np.uint8))
        padded = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        padded[: colour.shape[0], : colour.shape[1]] = colour[:HEIGHT, :WIDTH]
        cells = self._networks.find(padded)
        share = sigmoid(cells[0].astype(np.float64))
        peaks = (share >= SURE) & (share >= cv2.dilate(share, np.ones((5, 5))))
        best = sorted(np.argwhere(peaks).tolist(), key=lambda at: -share[*at])[:MOST_HANDS]
        return [_hand(camera, cells[:, row, column], (row, column), scale) for row, column in best]

    def _start(self, views: tuple[int, int], hands: tuple[FoundHand, FoundHand]) -> Array | None:
        """The points of a hand that two views see; None where they do not meet, or its size is no hand's."""
        projections = [self._rig.matrices[k] for k in views]
        middle = triangulate(projections, [hand.middle for hand in hands])
        if not np.isfinite(middle).all():
            return None
        ways = []
        for projection, hand in zip(projections, hands, strict=True):
            seen, jacobian, depth = image_of(projection, middle)
            unit_px = UNIT_M * float(np.linalg.norm(jacobian, 2))
            ratio = hand.unit_px / unit_px
            if depth <= 0.0 or np.linalg.norm(seen - hand.middle) > MOST_OFF * unit_px:
                return None
            if not 1.0 / OTHER_SIZE < ratio < OTHER_SIZE:
                return None
            ways.append(hand.middle + hand.direction * HALF_PALM_M / UNIT_M * unit_px)
        along = triangulate(projections, ways) - middle
        return straight_arm(middle, along / max(float(np.linalg.norm(along)), 1e-6))


def straight_arm(middle: Array, along: Array) -> Array:
    """Make the points (22, 3) in m of an arm of which only the palm's middle (3,) and direction (3,) are known."""
    points = np.tile(middle + HALF_PALM_M * along, (POINTS, 1))
    points[WRIST] = middle - HALF_PALM_M * along
    points[ELBOW] = points[WRIST] - FOREARM_M * along
    return points


def _hand(camera: CameraCalibration, answer: NDArray[np.float32], at: tuple[int, int], scale: float) -> FoundHand:
    (row, column), cell = at, answer.astype(np.float64)
    middle = (np.array([column + 0.5, row + 0.5]) + cell[2:4]) * CELL_PX / scale
    tip = middle + cell[4:6]
    middle, tip = camera.undistort_pixels(np.array([middle, tip], dtype=np.float64))
    direction = tip - middle
    unit_px = float(np.exp(cell[6])) * WIDTH / scale
    along = direction / max(float(np.linalg.norm(direction)), 1e-6)
    return FoundHand(middle, along, unit_px, float(sigmoid(cell[0])))
