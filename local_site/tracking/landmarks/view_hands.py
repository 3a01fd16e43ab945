"""The hands in one camera's frames: each frame is searched or followed once, and interpolated between two exposures."""

from dataclasses import replace
from functools import partial

import cv2
import numpy as np

from common.cameras.camera import Frame, Image
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration
from local_site.calibration.triangulation import project
from local_site.tracking.landmarks.hand_landmarks import HandLandmarks
from local_site.tracking.landmarks.view_follower import ViewFollower
from local_site.tracking.tracker import FrameCache, View

FOLLOWED_SCORE, FOUND_SCORE = 0.12, 0.5  # where two views agree, and where a hand is new
OTHER_CROP_SCORE = 0.3  # where the best of several crops is taken
TURNED_RIGHT = 0.5
# Crops in which a hand is seen that one crop misses, or shows as its mirror image: turned, rad, and scaled.
OTHER_CROPS = ((0.44, 1.0), (-0.44, 1.0), (0.0, 1.25), (0.79, 1.0), (-0.79, 1.0))

Motion = tuple[Array, Array]  # landmarks (21, 3) in m before and now


class ViewHands:
    """The hands that one camera shows at an instant."""

    def __init__(self, camera: CameraCalibration, follower: ViewFollower, right_arm: bool) -> None:
        self._camera, self._follower, self._right_arm = camera, follower, right_arm
        self._frames = FrameCache(_blend)

    def hands(self, view: View, *, quickly: bool = False) -> list[HandLandmarks]:
        """The hand that is followed, or, with none, what the next search finds."""
        if self._follower.is_following:
            found = self._frames.at(view, partial(self._follow, quickly=quickly))
            if not isinstance(found, str):
                return [found]
            self.lose()
        return [hand for hand in self._follower.search(as_bgr(view.current.image)) if hand.score >= FOUND_SCORE]

    def carried(self, hand: HandLandmarks, motion: Motion) -> HandLandmarks | None:
        """The hand of the picture before, moved as its landmarks in m are expected to; None if it was not sure."""
        if hand.carried or hand.score < FOUND_SCORE or self.side(hand) < TURNED_RIGHT:
            return None
        before, now = (self._camera.distort_pixels(project(self._camera.matrix, points)) for points in motion)
        return replace(hand, points=hand.points + now - before, carried=True)

    def again(self, view: View, seen: HandLandmarks, attempt: int) -> HandLandmarks:
        """The hand of the current frame in another crop, where that shows it more clearly as this side's."""
        turn, scale = OTHER_CROPS[attempt % len(OTHER_CROPS)]
        other = self._follower.again(as_bgr(view.current.image), seen.crop.changed(turn, scale))
        better = other.score >= FOLLOWED_SCORE and self.side(other) > self.side(seen)
        return other if better else seen

    def side(self, hand: HandLandmarks) -> float:
        """Return how much it looks like a hand of the operator's side, from 0 to 1."""
        return hand.for_side(self._right_arm)

    def keep(self, hand: HandLandmarks) -> None:
        """Follow this hand from now on."""
        self._follower.keep(hand)

    def lose(self) -> None:
        """Search from now on."""
        self._follower.lose()

    @property
    def is_following(self) -> bool:
        """Return whether it knows where the hand is."""
        return self._follower.is_following

    def _follow(self, frame: Frame, *, quickly: bool) -> HandLandmarks | str:
        image = as_bgr(frame.image)
        hand = self._follower.follow(image, quickly=quickly)
        if quickly and (hand is None or hand.score < FOUND_SCORE or self.side(hand) < TURNED_RIGHT):
            hand = self._follower.follow(image, quickly=False)
        if hand is not None and hand.score < FOLLOWED_SCORE:
            hand = self._clearest(image, hand)
        if hand is None or hand.score < FOLLOWED_SCORE:
            return f"{self._camera.name}: the hand is not seen where it was"
        return hand

    def _clearest(self, image: Image, hand: HandLandmarks) -> HandLandmarks | None:
        """The surest of other crops around a hand that is hardly seen: a hand that turns fast is missed in one only."""
        crop = hand.crop
        for turn, scale in OTHER_CROPS:
            hand = max(hand, self._follower.again(image, crop.changed(turn, scale)), key=lambda seen: seen.score)
            if hand.score >= FOUND_SCORE:
                break
        return hand if hand.score >= OTHER_CROP_SCORE else None


def as_bgr(image: Image) -> Image:
    """A picture (H, W) or (H, W, C) in BGR (H, W, 3)."""
    if image.ndim == 3 and image.shape[2] == 3:
        return image
    grey = image if image.ndim == 2 else image[..., 0]
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(grey), cv2.COLOR_GRAY2BGR), dtype=np.uint8)


def _blend(before: HandLandmarks, now: HandLandmarks, weight: float) -> HandLandmarks:
    points: Array = (1 - weight) * before.points + weight * now.points
    return replace(now, points=points)
