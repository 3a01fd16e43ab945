"""Which hands of the views are the same one, and where its landmarks are."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project, triangulate_many
from local_site.tracking.landmarks.hand_landmarks import PALM, HandLandmarks

MOST_RESIDUAL_PX = 10.0  # of the palm's points, for a picture of 480 rows
ROWS = 480.0


@dataclass(frozen=True, slots=True)
class SeenHand:
    """One hand in two or more views: its landmarks (21, 3) in m, by view what was seen, and how far the views miss.

    `residual_px` is the rms distance of the palm's points from their projections, over all views.
    """

    points: Array
    views: dict[int, HandLandmarks]
    residual_px: float

    @property
    def right(self) -> float:
        """How much it looks like a right hand, from 0 to 1."""
        return float(np.mean([hand.right for hand in self.views.values()]))


class HandPairing:
    """Finds the hand that two or more views agree on."""

    def __init__(self, rig: Rig) -> None:
        self._rig, self._projections = rig, rig.matrices

    def pair(self, candidates: Sequence[Sequence[HandLandmarks]]) -> SeenHand | None:
        """The hand on which the views agree best; None where no two agree on one within the calibrated volume."""
        found = [
            seen
            for i, j in combinations(range(len(candidates)), 2)
            for one in candidates[i]
            for other in candidates[j]
            if (seen := self.meet({i: one, j: other})) is not None
        ]
        return min(found, key=lambda seen: seen.residual_px, default=None)

    def meet(self, views: dict[int, HandLandmarks]) -> SeenHand | None:
        """The hand of these views; None if they do not agree on it, or it is outside the calibrated volume."""
        matrices = [self._projections[k] for k in views]
        pixels = [self._rig.cameras[k].undistort_pixels(hand.points) for k, hand in views.items()]
        points = triangulate_many(matrices, np.stack(pixels, axis=1))
        palm = list(PALM)
        off = [project(m, points[palm]) - seen[palm] for m, seen in zip(matrices, pixels, strict=True)]
        residual_px = float(np.sqrt(np.mean(np.sum(np.square(off), axis=-1))))
        if not residual_px <= MOST_RESIDUAL_PX or not self._rig.contains(points[palm].mean(axis=0)):
            return None
        return SeenHand(points, views, residual_px)
