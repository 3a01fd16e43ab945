"""Follows one hand through the pictures of one camera, and searches for hands after a loss."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from local_site.tracking.landmarks.crop import Crop
from local_site.tracking.landmarks.hand_landmarks import HandLandmarker, HandLandmarks
from local_site.tracking.landmarks.palm_detector import Palm, PalmDetector

SQUARE = 0.83  # of the picture's height: small hands are found in parts of the picture only
BRIGHTER = 1.8
MOST_HANDS = 3
CANDIDATE_SCORE = 0.3
SEARCH_EVERY = 2  # instants, once there is a hand that only this camera sees


@dataclass(frozen=True, slots=True)
class Region:
    """A part of a picture in which palms are searched: a fraction of the way from its left and top, and a gain."""

    square: bool = False
    left: float = 0.0
    top: float = 0.0
    gain: float = 1.0


_CORNERS = tuple((left, top) for top in (0.0, 1.0) for left in (0.0, 1.0))
SEARCHES = (
    Region(),
    *(Region(True, left, top) for left, top in _CORNERS),
    Region(gain=BRIGHTER),
    *(Region(True, left, top, BRIGHTER) for left, top in _CORNERS),
)


class ViewFollower:
    """The hands that one camera may see: the one that is followed, or all that one search finds."""

    def __init__(self, detector: PalmDetector, careful: HandLandmarker, quick: HandLandmarker) -> None:
        """`quick` takes half the time of `careful`: exact enough where outlines show the hand, too."""
        self._detector, self._landmarker, self._quick = detector, careful, quick
        self._crop: Crop | None = None
        self._candidates: list[Crop] = []
        self._searches = self._instants = 0

    @property
    def is_following(self) -> bool:
        """Return whether it knows where the hand is."""
        return self._crop is not None

    def follow(self, image: Image, *, quickly: bool) -> HandLandmarks | None:
        """The hand that is followed, in a BGR picture (H, W, 3)."""
        landmarker = self._quick if quickly else self._landmarker
        return None if self._crop is None else landmarker.find(image, self._crop)

    def search(self, image: Image) -> list[HandLandmarks]:
        """All hands found so far and still seen, and those that the next search finds, the surest first."""
        hands = [hand for crop in self._candidates if (hand := self._quick.find(image, crop)).score >= CANDIDATE_SCORE]
        self._instants += 1
        if not hands or self._instants % SEARCH_EVERY == 0:
            region = SEARCHES[self._searches % len(SEARCHES)]
            self._searches += 1
            found = [self._landmarker.find(image, palm.crop) for palm in self._palms(image, region)[:MOST_HANDS]]
            hands += [hand for hand in found if not any(_is_same(hand, known) for known in hands)]
        best = sorted(hands, key=lambda hand: -hand.score)[:MOST_HANDS]
        self._candidates = [hand.next_crop() for hand in best if hand.score >= CANDIDATE_SCORE]
        return best

    def again(self, image: Image, crop: Crop) -> HandLandmarks:
        """The hand in a crop of one's own choice."""
        return self._landmarker.find(image, crop)

    def keep(self, hand: HandLandmarks) -> None:
        """Follow this hand from now on."""
        self._crop, self._searches, self._candidates = hand.next_crop(), 0, []

    def lose(self) -> None:
        """Search from now on, first where the hand was."""
        if self._crop is not None:
            self._candidates, self._crop = [self._crop], None

    def _palms(self, image: Image, region: Region) -> Sequence[Palm]:
        bright = image if region.gain == 1.0 else cv2.convertScaleAbs(image, alpha=region.gain)
        if not region.square:
            return self._detector.find(np.asarray(bright, dtype=np.uint8))
        height, width = image.shape[:2]
        side = round(SQUARE * min(height, width))
        left, top = round(region.left * (width - side)), round(region.top * (height - side))
        part = np.ascontiguousarray(bright[top : top + side, left : left + side], dtype=np.uint8)
        moved = np.array([left, top], dtype=float)
        found = self._detector.find(part)
        return [Palm(palm.score, Crop(palm.crop.centre + moved, palm.crop.side_px, palm.crop.angle)) for palm in found]


def _is_same(one: HandLandmarks, other: HandLandmarks) -> bool:
    """Return whether two results are the same hand: their middles lie within half a crop."""
    apart = float(np.linalg.norm(one.points.mean(axis=0) - other.points.mean(axis=0)))
    return apart < 0.25 * (one.crop.side_px + other.crop.side_px)
