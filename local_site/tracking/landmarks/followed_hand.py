"""The hand between instants: the hand model fitted to landmarks, and to the outlines where they agree with them."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from common.geometry import Array
from local_site.tracking.landmarks.hand_starts import any_posture, laid_upon, pose_from_landmarks, scale_of
from local_site.tracking.silhouette.hand_model.fit import HandFit, HandView, Prior, fit_hand
from local_site.tracking.silhouette.hand_model.habits import (
    Belief,
    Habits,
    LimbEvidence,
    near_last,
    prior_information,
)
from local_site.tracking.silhouette.hand_model.landmark_equations import landmark_points
from local_site.tracking.silhouette.hand_model.skeleton import EXTRA_CURL, PALM, HandPose, Person
from local_site.tracking.silhouette.tips import INDEX, THUMB, Tip, find_tips

ITERATIONS = 6
LOOSE_WRIST_M = 0.03
REMEMBERED_SCALES = 60
"""The hand's own landmarks of the palm, which move as one."""


@dataclass(frozen=True, slots=True)
class FittedHand:
    """A hand at one instant: the fit, and the tips of index and thumb on the skin."""

    fit: HandFit
    index: Tip
    thumb: Tip
    hand_open: bool


class FollowedHand:
    """Fits a hand from instant to instant; the sizes that it learns are one operator's and are kept through losses."""

    def __init__(self, right_arm: bool, own: Belief | None = None, scale: float | None = None) -> None:
        """`own` and `scale`, the size relative to the average hand, were learned in an earlier run."""
        self._right_arm = right_arm
        self._habits = Habits(own)
        self._scales: deque[float] = deque([] if scale is None else [scale] * REMEMBERED_SCALES, REMEMBERED_SCALES)
        self._last: tuple[HandPose, Array] | None = None
        self._open = False

    def forget(self) -> None:
        """Start from an unknown pose with the next instant."""
        self._last, self._open = None, False

    def track(self, views: Sequence[HandView], landmarks: Array, arm: LimbEvidence | None) -> FittedHand | None:
        """The hand of views with landmarks, whose triangulation (21, 3) in m is `landmarks`."""
        person = self._person(landmarks, arm)
        belief = any_posture(self._habits.own)
        fits = [
            fit_hand(views, start, _prior(known, start, arm), person, ITERATIONS)
            for start, known in self._starts(landmarks, person, belief)
        ]
        fit = min(fits, key=lambda fit: fit.cost)
        self._last = fit.pose, landmarks
        self._habits.learn_fit(fit)
        index, thumb = find_tips(views, fit.spheres, (INDEX, THUMB))
        return FittedHand(fit, index, thumb, self._open)

    def _person(self, landmarks: Array, arm: LimbEvidence | None) -> Person:
        if len(self._scales) < REMEMBERED_SCALES:
            self._scales.append(scale_of(landmarks, self._right_arm))
        away = landmarks[0] - landmarks[9] if arm is None else arm.elbow - arm.wrist
        return Person(median(self._scales), self._right_arm, away / max(float(np.linalg.norm(away)), 1e-6))

    def _starts(self, landmarks: Array, person: Person, belief: Belief) -> list[tuple[HandPose, Belief]]:
        """The last pose moved with the landmarks, and a new one from the landmarks alone."""
        new = pose_from_landmarks(landmarks, person, belief.posture[PALM:])
        if self._last is None:
            return [(new, belief)]
        last, before = self._last
        rotation, shift, _ = laid_upon(before, landmarks)
        moved = HandPose(rotation @ last.wrist + shift, rotation @ last.rotation, last.posture)
        return [(moved, near_last(belief, last.posture)), (new, belief)]


def _prior(belief: Belief, start: HandPose, arm: LimbEvidence | None) -> Prior:
    if arm is not None:
        return arm.prior(belief, start)
    information = prior_information(LOOSE_WRIST_M**2 * np.eye(3), belief.information, turn_known=True)
    return Prior(start.wrist, start.rotation, belief.posture, information)
