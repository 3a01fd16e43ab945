"""The hand's size and whether it is open: fingers apart, or stretched beyond their reach when curled."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import reprojection_residual, triangulate
from local_site.tracking.silhouette.features import Features

MAX_REACH_RESIDUAL = 0.4
OPEN_REACH = 1.1
OPEN_GAP = 1.5
OPEN_GAP_SIGMA = 0.2
MAX_REACH = 1.6
THUMB_PER_FOREARM = 0.52
INDEX_PER_FOREARM = 0.66


@dataclass(frozen=True, slots=True)
class HandShape:
    """Distances in m of the hand held like a gripper: wrist to index tip, wrist to thumb tip, index tip to thumb tip,
    and wrist to the farthest point of the outline; the last two are None while the hand is not known.

    `gap_sigma` is the relative standard deviation of the gap.
    """

    index: float
    thumb: float
    gap: float | None = None
    reach: float | None = None
    gap_sigma: float = 0.10
    right_arm: bool = True


def typical_shape(forearm_length: float, right_arm: bool) -> HandShape:
    """What the proportions of the body say of a hand whose shape is not known yet."""
    return HandShape(INDEX_PER_FOREARM * forearm_length, THUMB_PER_FOREARM * forearm_length, right_arm=right_arm)


def hand_reach(projections: Sequence[Array], features: Sequence[Features], wrist: Array) -> float | None:
    """Distance in m from the wrist (3,) to where the rays to the outlines' farthest points meet; None if they miss."""
    hands = [f.hand for f in features[:2] if f.hand is not None]
    if len(hands) < 2:
        return None
    pixels = [hand.farthest for hand in hands]
    point = triangulate(projections[:2], pixels)
    residual = reprojection_residual(projections[:2], pixels, point)
    if residual > MAX_REACH_RESIDUAL * min(f.half_width for f in features[:2]):
        return None
    return float(np.linalg.norm(point - wrist))


def is_open(features: Sequence[Features], reach: float | None, shape: HandShape) -> bool:
    """Whether the hand is open: fingers stand apart in a view (thesis 4.2), or it reaches farther than when curled.

    The second holds where an open hand is seen edge-on and no view shows its fingers apart.
    """
    if any(f.hand is not None and f.hand.spread for f in features):
        return True
    return reach is not None and shape.reach is not None and OPEN_REACH * shape.reach < reach < MAX_REACH * shape.reach


def opened(shape: HandShape, reach: float | None) -> HandShape:
    """The shape once the fingers are stretched: the index reaches as much farther as the whole hand does, the gap is
    wider and no longer certain."""
    if shape.gap is None or shape.reach is None:
        return shape
    ratio = OPEN_REACH if reach is None else min(max(reach / shape.reach, 1.0), MAX_REACH)
    return replace(shape, index=ratio * shape.index, gap=OPEN_GAP * shape.gap, gap_sigma=OPEN_GAP_SIGMA)
