"""An operator's body, learned from the first pairs of images and kept between runs: the arm's lengths, the hand."""

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from common.messages.hand import TrackingStatus
from local_site.tracking.config import SilhouetteConfig
from local_site.tracking.silhouette.hand_model.fit import Effort, HandView, search_hand
from local_site.tracking.silhouette.hand_model.habits import Belief, Habits, LimbEvidence
from local_site.tracking.silhouette.hand_model.skeleton import PALM, PARAMETERS
from local_site.tracking.silhouette.hand_tracker import HandEstimate, HandTracker
from local_site.tracking.silhouette.joints import Body
from local_site.tracking.tracker import TrackingReason

OTHER_BODY_FRACTION = 0.08
MOST_PAIRS = 100  # so that a body that grows is followed
MAX_ANGLE, MAX_LOG_SIZE = 2.5, 0.7

Row = Annotated[tuple[float, ...], Meta(min_length=PARAMETERS, max_length=PARAMETERS)]


class OperatorProfile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An operator's hand and forearm: `scale` against the average hand, how a gripper is held (10,) with the
    information (10, 10) about it, the forearm's length in m, and from how many pairs of images that is."""

    scale: Annotated[float, Meta(ge=0.4, le=2.0)]
    posture: Row
    information: Annotated[tuple[Row, ...], Meta(min_length=PARAMETERS, max_length=PARAMETERS)]
    forearm_length_m: Annotated[float, Meta(ge=0.1, le=0.5)]
    pairs: Annotated[int, Meta(ge=1, le=MOST_PAIRS)]

    @property
    def habits(self) -> Belief:
        """The usual hold of the hand, with its information."""
        return Belief(np.array(self.posture), np.array(self.information))


def make_profile(scale: float, habits: Belief, forearm_length_m: float, pairs: int) -> OperatorProfile:
    """The profile of what has been learned."""
    return OperatorProfile(
        scale=scale,
        posture=tuple(habits.posture.tolist()),
        information=tuple(tuple(row) for row in habits.information.tolist()),
        forearm_length_m=forearm_length_m,
        pairs=min(pairs, MOST_PAIRS),
    )


def profile_mistakes(profile: OperatorProfile) -> list[str]:
    """List what is wrong with a profile; msgspec has checked types, lengths and sizes."""
    mistakes = []
    angles, sizes = profile.posture[:PALM], profile.posture[PALM:]
    if not all(abs(angle) < MAX_ANGLE for angle in angles) or not all(abs(size) < MAX_LOG_SIZE for size in sizes):
        mistakes.append("posture is not that of a hand")
    information = np.array(profile.information)
    if not np.isfinite(information).all() or not np.allclose(information, information.T):
        mistakes.append("information is not symmetric, or not finite")
    elif not math.isfinite(float(np.sum(information))) or np.linalg.eigvalsh(information)[0] <= 0:
        mistakes.append("information is not positive")
    return mistakes


MAX_TRIALS = 2  # times the pairs to learn from: a profile whose hand is not found in them belongs to another body
HANDEDNESS_EFFORT = Effort(rolls=12, kept=4)
CLEARLY_WORSE = 1.2


def looks_like_the_other_arm(views: Sequence[HandView], arm: LimbEvidence, right_arm: bool) -> bool:
    """Return whether an average hand of the other arm explains the outlines clearly better than one of this arm.

    In exchanged and mirrored pictures a right arm looks like a left one. Both are searched for with the same effort.
    Thumb and index look alike on both arms: the curled fingers on the palm's side decide.
    """
    prior = arm.prior(Habits().closed)
    own, other = (
        search_hand(views, arm.far_end, prior, arm.person(side), HANDEDNESS_EFFORT).cost
        for side in (right_arm, not right_arm)
    )
    return own > CLEARLY_WORSE * other


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
        """The operator as learned in all runs, None until this one has learned the arm and the hand."""
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
            return TrackingStatus.INITIALISING, "; ".join(reasons)
        self._lengths.append((forearm_m, to_sleeve_m))
        progress = f"{self._lesson} ({len(self._lengths)} of {self._config.initial_pairs} pairs)"
        if len(self._lengths) < self._config.initial_pairs:
            return TrackingStatus.INITIALISING, progress
        forearm, upper = (_median(values) for values in zip(*self._lengths, strict=True))
        if self._shown is not None and looks_like_the_other_arm(*self._shown, self._config.right_arm):
            return self._restart(TrackingReason.OTHER_ARM)
        if self._profile is not None:
            known_m, pairs = self._profile.forearm_length_m, self._profile.pairs
            if not abs(forearm / known_m - 1) < OTHER_BODY_FRACTION:
                return self._restart_without_profile()
            total = known_m * pairs + forearm * self._config.initial_pairs
            forearm = total / (pairs + self._config.initial_pairs)
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
