"""The arm's outlines in all views: before a dark wall by a threshold, else by this arm's colour and the empty room."""

import numpy as np

from common.cameras.camera import Image
from local_site.calibration.rig import Rig
from local_site.tracking.features.view_meter import ViewMeter
from local_site.tracking.foreground.dark_wall import DarkWall
from local_site.tracking.foreground.found_foreground import FoundForeground
from local_site.tracking.landmarks.hand_landmarks import MIDDLE_TIP, WRIST
from local_site.tracking.landmarks.hand_pairing import SeenHand
from local_site.tracking.landmarks.view_hands import as_bgr
from local_site.tracking.learned.found_meter import FoundMeter
from local_site.tracking.silhouette.arm_finder import ArmFinder, NoArm, SeenArm
from local_site.tracking.silhouette.joints import Body
from local_site.tracking.tracker import TrackingReason, Views

MOST_WRIST_OFF_M = 0.06  # the wrist's landmark lies on the crease, 2 cm from the joint
SHORTEST_M = 0.18  # of any operator's forearm
WITHIN = 0.9  # of the landmarks: inside the silhouette of a hand before a dark wall


class ArmOutlines:
    """Finds the arm that belongs to a hand."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._meters = [FoundMeter(camera) for camera in rig.cameras]
        self._before_wall = ArmFinder(rig, [ViewMeter(camera, DarkWall()) for camera in rig.cameras])
        self._in_room = ArmFinder(rig, self._meters)
        self._foreground = FoundForeground(rig)
        self.finder = self._before_wall

    @property
    def in_room(self) -> bool:
        """Whether the arm is told from a room, not from a dark wall."""
        return self.finder is self._in_room

    def learn_room(self, views: Views) -> None:
        """Learn the room from pictures without the arm."""
        self._foreground.learn_room(_pictures(views))

    def find(self, views: Views, body: Body, hand: SeenHand, *, starting: bool) -> SeenArm | NoArm:
        """The arm whose wrist is that of the hand.

        While `starting`, the wall behind the arm is tried first: a threshold is more exact and faster where it serves.
        """
        if starting:
            arm = _with_hand(self._before_wall.find(views, body), hand)
            if isinstance(arm, SeenArm) and _hold(arm, hand):
                self.finder = self._before_wall
                return arm
            self.finder = self._in_room
        if self.finder is self._before_wall:
            return _with_hand(self._before_wall.find(views, body), hand)
        return _with_hand(self._found(views, body, hand), hand)

    def find_without_hand(self, views: Views, body: Body) -> SeenArm | NoArm:
        """The arm before a dark wall, whose outlines need no hand to begin with."""
        if self.finder is not self._before_wall:
            return NoArm(TrackingReason.NO_HAND)
        return self._before_wall.find(views, body)

    def forget(self) -> None:
        """Search everywhere from now on."""
        self._before_wall.forget()
        self._in_room.forget()
        self._foreground.forget()

    def _found(self, views: Views, body: Body, hand: SeenHand) -> SeenArm | NoArm:
        found = self._foreground.find(_pictures(views), hand)
        for meter, view, silhouette in zip(self._meters, views.views, found.silhouettes, strict=True):
            meter.show(view.current, silhouette)
        hints = [
            found.tubes.posture(matrix, hand.pixels[k][MIDDLE_TIP]) if k in hand.pixels else None
            for k, matrix in enumerate(self._rig.matrices)
        ]
        arm = self._in_room.find(views, body, hints)
        if not _is_short(arm):
            return arm
        self._in_room.forget()  # a bend within the forearm was taken for the elbow
        arm = self._in_room.find(views, body, hints)
        return NoArm(TrackingReason.NO_ARM) if _is_short(arm) else arm


def _pictures(views: Views) -> list[Image]:
    return [as_bgr(view.current.image) for view in views.views]


def _with_hand(arm: SeenArm | NoArm, hand: SeenHand) -> SeenArm | NoArm:
    """The arm, if its wrist is that of the hand."""
    if isinstance(arm, NoArm):
        return arm
    off_m = float(np.linalg.norm(arm.joints.wrist - hand.points[WRIST]))
    return arm if off_m < MOST_WRIST_OFF_M else NoArm(TrackingReason.NO_ARM)


def _is_short(arm: SeenArm | NoArm) -> bool:
    """Whether the forearm of an arm is shorter than any operator's."""
    return isinstance(arm, SeenArm) and float(np.linalg.norm(arm.joints.wrist - arm.joints.elbow)) < SHORTEST_M


def _hold(arm: SeenArm, hand: SeenHand) -> bool:
    """Whether every silhouette holds the hand that its view sees."""
    for k, features in zip(arm.seen, arm.features, strict=True):
        if k in hand.pixels:
            grey, level = features.silhouette.grey, features.silhouette.level
            x, y = np.rint(hand.pixels[k]).astype(int).T
            inside = (x >= 0) & (y >= 0) & (x < grey.shape[1]) & (y < grey.shape[0])
            bright = grey[y[inside], x[inside]] > level
            if float(np.sum(bright)) < WITHIN * len(x):
                return False
    return True
