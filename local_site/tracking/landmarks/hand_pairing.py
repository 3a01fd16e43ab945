"""Pairing of hands: which ones of the views are the same hand, and where its landmarks are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project, triangulate_many
from local_site.tracking.landmarks.hand_landmarks import MIDDLE_KNUCKLE, PALM, WRIST, HandLandmarks

# Of the palm's length in the picture: 10 px of a palm of 50 px. Another person's hand misses by more.
MOST_MISFIT = 0.2


@dataclass(frozen=True, slots=True)
class SeenHand:
    """One hand in two or more views: its landmarks (21, 3) in m, by view what was seen, and how far the views miss.

    `pixels` (21, 2) are each view's landmarks in undistorted px. `residual_px` is the rms distance of the palm's points
    from their projections over all views, `misfit` the same in lengths of the palm in the picture.
    """

    points: Array
    views: Mapping[int, HandLandmarks]
    pixels: Mapping[int, Array]
    residual_px: float
    misfit: float

    @property
    def right(self) -> float:
        """Return how much it looks like a right hand, from 0 to 1."""
        return float(np.mean([hand.right for hand in self.views.values()]))

    @property
    def score(self) -> float:
        """Return how sure the least sure view is that it sees a hand, from 0 to 1."""
        return min(hand.score for hand in self.views.values())

    @property
    def palm(self) -> Array:
        """The palm's middle (3,) in m."""
        middle: Array = self.points[list(PALM)].mean(axis=0)
        return middle


class HandPairing:
    """Finds the hands that two or more views agree on."""

    def __init__(self, rig: Rig) -> None:
        self._rig, self._projections = rig, rig.matrices

    def pairs(self, candidates: Sequence[Sequence[HandLandmarks]]) -> list[SeenHand]:
        """The hands within the calibrated volume on which two views agree, the best agreement first, each with the
        further views that agree, too."""
        found = [
            self._with_others(seen, candidates)
            for i, j in combinations(range(len(candidates)), 2)
            for one in candidates[i]
            for other in candidates[j]
            if (seen := self.meet({i: one, j: other})) is not None
        ]
        return sorted(found, key=lambda seen: (-len(seen.views), seen.misfit))

    def meet(self, views: Mapping[int, HandLandmarks]) -> SeenHand | None:
        """The hand of these views; None if they do not agree on it, or it is outside the calibrated volume."""
        matrices = [self._projections[k] for k in views]
        pixels = {k: self._rig.cameras[k].undistort_pixels(hand.points) for k, hand in views.items()}
        points = triangulate_many(matrices, np.stack(list(pixels.values()), axis=1))
        palm = list(PALM)
        off = [project(m, points[palm]) - seen[palm] for m, seen in zip(matrices, pixels.values(), strict=True)]
        residual_px = float(np.sqrt(np.mean(np.sum(np.square(off), axis=-1))))
        misfit = residual_px / max(_palm_length_px(list(pixels.values())), 1e-6)
        if not misfit <= MOST_MISFIT or not self._rig.contains(points[palm].mean(axis=0)):
            return None
        return SeenHand(points, views, pixels, residual_px, misfit)

    def _with_others(self, seen: SeenHand, candidates: Sequence[Sequence[HandLandmarks]]) -> SeenHand:
        for k, hands in enumerate(candidates):
            if k not in seen.views:
                wider = [w for hand in hands if (w := self.meet({**seen.views, k: hand})) is not None]
                seen = min(wider, key=lambda hand: hand.misfit, default=seen)
        return seen


def _palm_length_px(pixels: Sequence[Array]) -> float:
    """The longest that any view shows the palm: the others see it foreshortened."""
    return max(float(np.linalg.norm(seen[MIDDLE_KNUCKLE] - seen[WRIST])) for seen in pixels)
