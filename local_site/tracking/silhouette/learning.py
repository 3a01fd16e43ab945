"""Learns the operator's body from the first pairs of images: the arm's lengths, the hand, and the operator."""

import math
from collections.abc import Sequence

import numpy as np

from common.messages.hand import TrackingStatus
from local_site.tracking.config import SilhouetteConfig
from local_site.tracking.reasons import TrackingReason, sentence
from local_site.tracking.silhouette.hand_model.fit import HandView
from local_site.tracking.silhouette.hand_model.habits import LimbEvidence
from local_site.tracking.silhouette.hand_model.search import looks_like_the_other_arm
from local_site.tracking.silhouette.hand_tracker import HandEstimate, HandTracker
from local_site.tracking.silhouette.joints import Body
from local_site.tracking.silhouette.operator_profile import OperatorProfile, make_profile

MAX_TRIALS = 2  # times the pairs to learn from: a profile whose hand is not found in them belongs to another body


class BodyLearning:
    """The lengths of the arm and the tracker of the hand, both of one operator.

    `body` has no lengths until they are learned. A profile that does not fit the arm is dropped.
    """

    def __init__(self, config: SilhouetteConfig, profile: OperatorProfile | None) -> None:
        self._config = config
        self._profile = profile
        self.body = Body()
        self.hand = self._new_hand()
        self._lesson = TrackingReason.LEARNING
        self._shown: tuple[Sequence[HandView], LimbEvidence] | None = None
        self._lengths: list[tuple[float, float]] = []
        self._trials = 0

    @property
    def profile(self) -> OperatorProfile | None:
        """What has been learned of the operator in all runs, None until this one has learned the arm and the hand."""
        length, hand = self.body.forearm_length, self.hand.learned
        if length is None or hand is None:
            return None
        before = 0 if self._profile is None else self._profile.pairs
        return make_profile(*hand, length, self._config.initial_pairs + before)

    def track_hand(self, views: Sequence[HandView], arm: LimbEvidence) -> HandEstimate | None:
        """The hand seen in the views; None if the model cannot explain the outlines."""
        self._shown = views, arm
        return self.hand.track(views, arm)

    def learn(
        self, forearm_m: float, to_sleeve_m: float, reasons: Sequence[TrackingReason]
    ) -> tuple[TrackingStatus, str]:
        """Take the median lengths of the first good pairs (thesis equation 3.26); `reasons` are doubts about this one.

        The distance from elbow to sleeve is NaN where the sleeve is not seen.
        """
        if self._profile is not None and not set(reasons) - {TrackingReason.HAND_UNCLEAR}:
            self._trials += 1
            if self._trials > MAX_TRIALS * self._config.initial_pairs:
                return self._restart_without_profile()
        if reasons:
            return TrackingStatus.INITIALISING, sentence(reasons)
        self._lengths.append((forearm_m, to_sleeve_m))
        progress = f"{self._lesson} ({len(self._lengths)} of {self._config.initial_pairs} pairs)"
        if len(self._lengths) < self._config.initial_pairs:
            return TrackingStatus.INITIALISING, progress
        forearm, upper = (_median(values) for values in zip(*self._lengths, strict=True))
        if self._shown is not None and looks_like_the_other_arm(*self._shown, self._config.right_arm):
            return self._restart(TrackingReason.OTHER_ARM)
        if self._profile is not None and not self._profile.is_of(forearm):
            return self._restart_without_profile()
        if self._profile is not None:
            forearm = self._profile.length_with(forearm, self._config.initial_pairs)
        self.body = Body(forearm, upper if math.isfinite(upper) else None)
        return TrackingStatus.INITIALISING, progress

    def _new_hand(self) -> HandTracker:
        known, config = self._profile, self._config
        if known is None:
            return HandTracker(config.initial_pairs, config.right_arm)
        return HandTracker(config.initial_pairs, config.right_arm, known.habits, known.scale)

    def _restart_without_profile(self) -> tuple[TrackingStatus, str]:
        self._profile = None
        return self._restart(TrackingReason.OTHER_BODY)

    def _restart(self, why: TrackingReason) -> tuple[TrackingStatus, str]:
        self._lengths.clear()
        self._lesson = why
        self.hand = self._new_hand()
        return TrackingStatus.INITIALISING, why


def _median(values: Sequence[float]) -> float:
    """The median of the finite values, NaN without any."""
    finite = [value for value in values if math.isfinite(value)]
    return float(np.median(finite)) if finite else math.nan
