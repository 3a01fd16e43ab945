"""The 21 landmarks of a hand in one picture, from a crop that holds it."""

from dataclasses import dataclass

import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.tracking.landmarks.crop import Crop, upright
from local_site.tracking.landmarks.network import LandmarkNetwork

WRIST, THUMB_TIP, INDEX_TIP, MIDDLE_KNUCKLE, MIDDLE_TIP = 0, 4, 8, 9, 12
PALM = (0, 1, 2, 3, 5, 6, 9, 10, 13, 14, 17, 18)  # the landmarks that move least with the fingers
POINTERS = (6, 10, 14)  # the middle joints of index, middle and ring finger
NEXT_SCALE, NEXT_SHIFT = 2.0, 0.1


@dataclass(frozen=True, slots=True)
class HandLandmarks:
    """A hand in one picture: 21 points (21, 2) in px, how sure it is a hand, and a right one, each from 0 to 1.

    Where it is `carried`, the picture was not looked at: the points are those of the one before, moved with the hand.
    """

    points: Array
    score: float
    right: float
    crop: Crop
    carried: bool = False

    def for_side(self, right_arm: bool) -> float:
        """Return how much it looks like a hand of a side, from 0 to 1."""
        return self.right if right_arm else 1.0 - self.right

    def next_crop(self) -> Crop:
        """The crop in which the next picture shows the hand, if it moves little."""
        palm, (index, middle, ring) = self.points[list(PALM)], self.points[list(POINTERS)]
        angle = upright(self.points[WRIST], (index + ring) / 4 + middle / 2)
        axes = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        turned = palm @ axes
        low, high = turned.min(axis=0), turned.max(axis=0)
        side = float((high - low).max())
        centre = (low + high) / 2 - np.array([0.0, NEXT_SHIFT * (high - low)[1]])
        return Crop(axes @ centre, NEXT_SCALE * side, angle)


class HandLandmarker:
    """Landmarks of the hand in a crop."""

    def __init__(self, network: LandmarkNetwork) -> None:
        self._network = network

    def find(self, image: Image, crop: Crop) -> HandLandmarks:
        """The landmarks in a BGR picture (H, W, 3)."""
        size = self._network.side_px
        flat, score, right = self._network.run(crop.cut(image, size))
        points = crop.to_picture(flat.reshape(21, 3)[:, :2].astype(float) / size)
        return HandLandmarks(points, float(score[0]), float(right[0]), crop)
