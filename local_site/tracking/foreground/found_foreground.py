"""The operator's bare arm in an ordinary room: found by its colour and the room in all views, starting from the hand."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.foreground.arm_view import ArmView
from local_site.tracking.foreground.tubes import (
    FOREARM_HALF_WIDTHS_M,
    FOREARM_M,
    UPPER_ARM_HALF_WIDTHS_M,
    UPPER_ARM_M,
    ArmTubes,
    Tube,
    find_tube,
)
from local_site.tracking.landmarks.hand_landmarks import MIDDLE_KNUCKLE, WRIST
from local_site.tracking.landmarks.hand_pairing import SeenHand

AVERAGE_PALM_M = 0.093  # from the wrist to the middle knuckle
SCALE_KEPT, LEAST_SCALE, MOST_SCALE = 0.95, 0.75, 1.25
FOREARM_ANGLE, UPPER_ARM_ANGLE = np.deg2rad(100.0), np.deg2rad(110.0)


@dataclass(frozen=True, slots=True)
class FoundArm:
    """By view the arm's silhouette, or a sentence why it is not to be trusted; and roughly where the limbs are."""

    silhouettes: tuple[Silhouette | str, ...]
    tubes: ArmTubes


class FoundForeground:
    """Finds the arm in the pictures of all views; its colour is learned from the hand on the way."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._views = tuple(ArmView(matrix) for matrix in rig.matrices)
        self._scale: float | None = None
        self._last: ArmTubes | None = None

    def learn_room(self, pictures: Sequence[Image]) -> None:
        """Learn the room from undistorted BGR pictures (H, W, 3), one of each view, without the arm."""
        for view, picture in zip(self._views, pictures, strict=True):
            view.learn_room(picture)

    def forget(self) -> None:
        """Search the arm all round with the next pictures; its colour and the room are kept."""
        self._last = None

    def find(self, pictures: Sequence[Image], hand: SeenHand) -> FoundArm:
        """The arm of a hand, seen in undistorted BGR pictures (H, W, 3), one of each view."""
        scale = self._follow_scale(hand.points)
        pixels = self._pixels(hand)
        before = None if self._last is None else moved(self._last, hand.points[WRIST])
        maps = [
            view.look(picture, seen, hand.points, before, scale)
            for view, picture, seen in zip(self._views, pictures, pixels, strict=True)
        ]
        palm_to_wrist = hand.points[WRIST] - hand.points[MIDDLE_KNUCKLE]
        axis = palm_to_wrist / max(float(np.linalg.norm(palm_to_wrist)), 1e-9)
        forearm = find_tube(
            maps,
            limb(hand.points[WRIST], axis, FOREARM_M, FOREARM_HALF_WIDTHS_M, scale),
            axis,
            FOREARM_ANGLE,
            None if self._last is None else self._last.forearm.direction,
        )
        upper_arm = find_tube(
            maps,
            limb(forearm.end, forearm.direction, UPPER_ARM_M, UPPER_ARM_HALF_WIDTHS_M, scale),
            forearm.direction,
            UPPER_ARM_ANGLE,
            None if self._last is None else self._last.upper_arm.direction,
        )
        tubes = ArmTubes(forearm, upper_arm)
        self._last = tubes
        silhouettes = tuple(
            view.silhouette(picture, tubes) for view, picture in zip(self._views, pictures, strict=True)
        )
        return FoundArm(silhouettes, tubes)

    def _follow_scale(self, points: Array) -> float:
        """The size of the operator's hand against an average one."""
        palm = float(np.linalg.norm(points[MIDDLE_KNUCKLE] - points[WRIST]))
        scale = min(max(palm / AVERAGE_PALM_M, LEAST_SCALE), MOST_SCALE)
        self._scale = scale if self._scale is None else SCALE_KEPT * self._scale + (1.0 - SCALE_KEPT) * scale
        return self._scale

    def _pixels(self, hand: SeenHand) -> list[Array]:
        """The landmarks (21, 2) in each view, undistorted: as seen, or projected where the view was not asked."""
        return [
            self._rig.cameras[k].undistort_pixels(hand.views[k].points) if k in hand.views else project(m, hand.points)
            for k, m in enumerate(self._rig.matrices)
        ]


def limb(start: Array, axis: Array, length: float, half_widths: tuple[float, float], scale: float) -> Tube:
    """An average limb at a start (3,) along an axis (3,), scaled."""
    return Tube(start, start + scale * length * axis, (scale * half_widths[0], scale * half_widths[1]), ())


def moved(tubes: ArmTubes, wrist: Array) -> ArmTubes:
    """The tubes with the wrist (3,) elsewhere."""
    forearm = tubes.forearm.moved(wrist)
    return ArmTubes(forearm, tubes.upper_arm.moved(forearm.end))
