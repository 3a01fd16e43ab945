"""The hand at one instant, as it was fitted: tips, covariances, and what its posture hides."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import MIN_VIEWS, HandFit
from local_site.tracking.silhouette.hand_model.skeleton import EXTRA_CURL, PIP_CURL
from local_site.tracking.silhouette.tips import Tip

MAX_COST = 1.5
BENT_INDEX, BENT_FINGERS = 1.0, 1.05  # rad, of the middle joints: of a fist, and of fingers that a thumb lies before
WRIST_SIGMA_M, HIDDEN_INDEX_SIGMA_M, UNCLEAR_SIGMA_M = 0.003, 0.006, 0.04


@dataclass(frozen=True, slots=True)
class FittedHand:
    """A hand at one instant: the fit, the tips of index and thumb on the skin, and whether the fingers are open.

    `landmark_views` and `outline_views` are how many views showed all its landmarks rightly, and its outline;
    `doubtful` is whether it fits far worse than usual, or no view tells thumb or index where the fit has them: as of a
    hand fitted as its mirror image, or with one finger for another.
    """

    fit: HandFit
    index: Tip
    thumb: Tip
    hand_open: bool
    fingers_together: bool
    landmark_views: int
    outline_views: int
    doubtful: bool = False

    @property
    def wrist_covariance(self) -> Array:
        """The wrist's covariance (3, 3) in m²: the fit's, and where in this hand the model's wrist is."""
        return np.asarray(np.linalg.inv(self.fit.information)[:3, :3], dtype=np.float64) + WRIST_SIGMA_M**2 * np.eye(3)

    @property
    def index_covariance(self) -> Array:
        """The index tip's covariance (3, 3) in m²; larger where no two outlines show its end before other fingers."""
        hidden_m = 0.0 if self.index.views >= MIN_VIEWS else HIDDEN_INDEX_SIGMA_M
        return self._widened(self.index.covariance + hidden_m**2 * np.eye(3))

    @property
    def thumb_covariance(self) -> Array:
        """The thumb tip's covariance (3, 3) in m²."""
        return self._widened(self.thumb.covariance)

    @property
    def is_clear(self) -> bool:
        """Whether landmarks or outlines of two views show a hand that the model explains."""
        is_shown = max(self.landmark_views, self.outline_views) >= MIN_VIEWS
        return self.fit.cost < MAX_COST and is_shown and not self.doubtful

    @property
    def is_fist(self) -> bool:
        """Whether the index is bent into the hand."""
        return bool(self.fit.pose.posture[PIP_CURL] > BENT_INDEX)

    @property
    def thumb_inferred(self) -> bool:
        """Whether neither landmarks nor outlines of two views show the thumb.

        Landmarks of a thumb that lies before bent fingers are a guess.
        """
        posture = self.fit.pose.posture
        is_before_fingers = posture[PIP_CURL] + posture[EXTRA_CURL] > BENT_FINGERS
        return self.thumb.views + (0 if is_before_fingers else self.landmark_views) < MIN_VIEWS

    def _widened(self, covariance: Array) -> Array:
        """A tip's covariance (3, 3): a hand that is unclear may be turned round."""
        widened: Array = covariance if self.is_clear else covariance + UNCLEAR_SIGMA_M**2 * np.eye(3)
        return widened
