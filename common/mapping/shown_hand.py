"""The hand as a sample shows it: the point that the tool copies, and the orientation; pure."""

import math

from common.geometry import Array, hand_rotation
from common.messages.base import Vector3
from common.messages.hand import HandArm, HandPoint


def shown_position(sample: HandArm, point: HandPoint) -> Vector3 | None:
    """The point of the hand that the tool copies, m in the operator frame; None where it is not measured."""
    return sample.palm if point is HandPoint.PALM else sample.wrist


def shown_orientation(sample: HandArm) -> Array | None:
    """The orientation `operator_R_hand` (3 x 3); None while a tip is missing or the hand is open.

    Also None where the thumb is inferred and the sample does not tell how well its points are known.
    """
    if sample.wrist is None or sample.index is None or sample.thumb is None or sample.hand_open:
        return None
    if sample.thumb_inferred and not _tells_covariances(sample):
        return None
    points = sample.wrist, sample.index, sample.thumb
    if not math.isfinite(sum(map(sum, points))):
        return None
    return hand_rotation(*points)


def _tells_covariances(sample: HandArm) -> bool:
    known = sample.covariance
    return known is not None and None not in (known.wrist, known.index, known.thumb)
