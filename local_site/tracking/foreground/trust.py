"""Whether the arm's region can be trusted: it holds the hand, shows a forearm, and does not run out into the room."""

import cv2
import numpy as np

from local_site.tracking.foreground.growing import WIDER, disc, within
from local_site.tracking.foreground.reasons import ForegroundReason
from local_site.tracking.foreground.room import Mask
from local_site.tracking.foreground.tubes import ArmTubes, RatioMap, Tube

LEAST_HAND, LEAST_FOREARM = 0.0, 0.3  # mean log ratios
NARROW = 0.5  # half widths of the forearm's tube
MOST_AROUND_FOREARM = 0.85  # of where a forearm can be: it covers two thirds of it
MOST_AROUND_ELBOW = 0.85  # of a disc: two limbs cover a half of it
ELBOW_DISC_M = 0.12
FEW = 30
LARGER, SMALLER, AREA_KEPT = 1.6, 0.6, 0.7


def objection(view: RatioMap, hand: tuple[Mask, Mask], arm: Mask, tubes: ArmTubes) -> ForegroundReason | None:
    """Why the region (h, w) of an arm is not to be trusted; None if it is.

    `hand` is where its bones are, and what is near them.
    """
    on_bones, near_hand = hand
    if np.count_nonzero(on_bones) < FEW:
        return ForegroundReason.NOT_SEEN
    if _mean(view, on_bones) < LEAST_HAND:
        return ForegroundReason.HAND_CUT
    if forearm_ratio(view, tubes.forearm) < LEAST_FOREARM:
        return ForegroundReason.NO_FOREARM
    return ForegroundReason.LEAKS if _leaks(view, near_hand, arm, tubes) else None


def forearm_ratio(view: RatioMap, forearm: Tube) -> float:
    """The mean log ratio along the middle of the forearm; 0 where it is outside of the picture."""
    return _mean(view, within(view, forearm, NARROW))


def _mean(view: RatioMap, squares: Mask) -> float:
    return float(cv2.mean(view.ratios, squares)[0])


def _leaks(view: RatioMap, near_hand: Mask, arm: Mask, tubes: ArmTubes) -> bool:
    elbow = disc(view, tubes.forearm.end, ELBOW_DISC_M)
    off_hand = np.asarray(near_hand == 0, np.uint8)
    forearm = within(view, tubes.forearm, WIDER) * (1 - elbow) * off_hand
    return _share(arm, forearm) > MOST_AROUND_FOREARM or _share(arm, elbow * off_hand) > MOST_AROUND_ELBOW


def _share(arm: Mask, squares: Mask) -> float:
    count = np.count_nonzero(squares)
    return np.count_nonzero(arm & squares) / count if count > FEW else 0.0


class AreaWatch:
    """Refuses an outline whose area differs much from those before, until it stays."""

    def __init__(self) -> None:
        self._area: float | None = None

    def objection(self, arm: Mask, view: RatioMap) -> ForegroundReason | None:
        """Why the region's area is not to be trusted; None if it is. It is learned in any case."""
        area = float(np.count_nonzero(arm)) * view.stride**2
        before = area if self._area is None else self._area
        self._area = AREA_KEPT * before + (1.0 - AREA_KEPT) * area
        return None if SMALLER * before < area < LARGER * before else ForegroundReason.JUMPED
