"""The operator's bare arm in an ordinary room: found in all views by its colour, starting from the hand."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.foreground.arm_colour import is_grey
from local_site.tracking.foreground.arm_view import ForegroundView
from local_site.tracking.foreground.reasons import ForegroundReason
from local_site.tracking.foreground.trust import LEAST_FOREARM, forearm_ratio
from local_site.tracking.foreground.tube_search import TubeSearch
from local_site.tracking.foreground.tubes import ArmTubes
from local_site.tracking.landmarks.hand_landmarks import MIDDLE_KNUCKLE, WRIST
from local_site.tracking.landmarks.hand_pairing import SeenHand


@dataclass(frozen=True, slots=True)
class FoundArm:
    """By view the arm's silhouette in undistorted px, or a sentence why there is none to be trusted; rough limbs."""

    silhouettes: tuple[Silhouette | str, ...]
    tubes: ArmTubes


class FoundForeground:
    """Finds the arm in the pictures of all views; its colour is learned from the hand on the way.

    Pictures are BGR (H, W, 3) as they were taken, one of each camera in the rig's order.
    """

    def __init__(self, rig: Rig) -> None:
        self._matrices = rig.matrices
        self._views = tuple(ForegroundView(camera) for camera in rig.cameras)
        self._tubes = TubeSearch()

    def learn_room(self, pictures: Sequence[Image]) -> None:
        """Learn the room from pictures without the arm."""
        for view, picture in zip(self._views, pictures, strict=True):
            view.learn_room(picture)

    def forget(self) -> None:
        """Search the arm all round with the next pictures; its colour and the room are kept."""
        self._tubes.forget()
        for view in self._views:
            view.forget()

    def find(self, pictures: Sequence[Image], hand: SeenHand) -> FoundArm:
        """The arm of a hand that was seen in these pictures."""
        wrist, pixels = hand.points[WRIST], self._pixels(hand)
        before = self._tubes.expected(wrist)
        maps = [
            view.look(picture, seen, wrist, before)
            for view, picture, seen in zip(self._views, pictures, pixels, strict=True)
        ]
        along = wrist - hand.points[MIDDLE_KNUCKLE]
        tubes = self._tubes.find(maps, wrist, along / max(float(np.linalg.norm(along)), 1e-9))
        if max(forearm_ratio(view, tubes.forearm) for view in maps) < LEAST_FOREARM:
            return FoundArm(_grey_named((ForegroundReason.COVERED,) * len(maps), pictures), tubes)
        silhouettes = _grey_named(tuple(view.silhouette(tubes) for view in self._views), pictures)
        if all(isinstance(found, Silhouette) for found in silhouettes):
            # A wrong outline that is learned from would spoil all that follow.
            for view in self._views:
                view.learn()
        return FoundArm(silhouettes, tubes)

    def _pixels(self, hand: SeenHand) -> list[Array]:
        """The landmarks (21, 2) in each view, undistorted: as seen, or projected where the view was not asked."""
        return [hand.pixels[k] if k in hand.pixels else project(m, hand.points) for k, m in enumerate(self._matrices)]


def _grey_named(
    found: Sequence[Silhouette | ForegroundReason], pictures: Sequence[Image]
) -> tuple[Silhouette | ForegroundReason, ...]:
    """What was found, but where nothing was in a grey picture, that this is why."""
    return tuple(
        ForegroundReason.NO_COLOUR if not isinstance(one, Silhouette) and is_grey(picture) else one
        for one, picture in zip(found, pictures, strict=True)
    )
