"""The arm's outlines in all views: before a dark wall by a threshold, else by this arm's colour and the empty room."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project
from local_site.tracking.features.features import Features
from local_site.tracking.features.view_meter import ViewMeter
from local_site.tracking.foreground.dark_wall import DarkWall
from local_site.tracking.landmarks.hand_pairing import SeenHand
from local_site.tracking.silhouette.arm_finder import ArmFinder, NoArm, SeenArm
from local_site.tracking.silhouette.joints import Body
from local_site.tracking.tracker import TrackingReason, Views

MOST_WRIST_OFF_M = 0.06  # the wrist's landmark lies on the crease, 2 cm from the joint


class ArmOutlines:
    """Finds the arm that belongs to a hand."""

    def __init__(self, rig: Rig) -> None:
        self.finder = ArmFinder(rig, [ViewMeter(camera, DarkWall()) for camera in rig.cameras])

    def find(self, views: Views, body: Body, hand: SeenHand) -> SeenArm | NoArm:
        """The arm whose wrist is that of the hand."""
        arm = self.finder.find(views, body)
        if isinstance(arm, NoArm):
            return arm
        off_m = float(np.linalg.norm(arm.joints.wrist - hand.points[0]))
        return arm if off_m < MOST_WRIST_OFF_M else NoArm(TrackingReason.NO_ARM)

    def forget(self) -> None:
        """Search everywhere from now on."""
        self.finder.forget()
