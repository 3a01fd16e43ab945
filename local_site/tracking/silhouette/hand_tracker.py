"""The hand from instant to instant: predicted, fitted, found again; index and thumb with their covariance."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import HandFit, HandView, Prior, contact, fit_hand
from local_site.tracking.silhouette.hand_model.habits import (
    Belief,
    Habits,
    near_last,
    posture_information,
    prior_information,
)
from local_site.tracking.silhouette.hand_model.placement import POSE, HandPose, Person, rotation_vector, turned
from local_site.tracking.silhouette.hand_model.search import Effort, search_hand
from local_site.tracking.silhouette.hand_model.skeleton import TYPICAL_FOREARM
from local_site.tracking.silhouette.tips import INDEX, THUMB, Tip, find_tip

ITERATIONS = 4
REFIT_ITERATIONS, OPINION_ITERATIONS = 8, 6
FIRST_SEARCH = Effort(rolls=32, kept=32)
QUICK_SEARCH = Effort(rolls=6, kept=3)
FIRST_SEARCH_EVERY = 30
AGAIN_ROLLS, AGAIN_KEPT = 6, 2
AGAIN_OFFSETS = (0.0, 0.5, 0.25, 0.75)
SEARCH_EVERY = 4
REMEMBERED_COSTS = 30
WORSE_FACTOR, WORSE_MARGIN = 1.4, 0.05
BAD_FACTOR, BAD_MARGIN = 1.7, 0.08
MAX_COST = 1.2
CLEARLY_BETTER = 0.95
# turns about the hand's own axes, rad, each with a change of the first posture angles
OPINIONS = (
    ((0.4, 0.0, 0.0), (0.0, 0.0, 0.0, 0.2)),
    ((0.0, 0.3, 0.0), (-0.3, 0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.3), (0.0, 0.0, 0.1, 0.2)),
    ((0.2, 0.2, 0.0), (0.2, -0.2, 0.0, 0.0)),
    ((0.8, 0.0, 0.0), (0.0, 0.0, 0.1, 0.0)),
)
MAX_TURN_AHEAD = 0.5


@dataclass(frozen=True, slots=True)
class HandEstimate:
    """The hand at one instant: wrist (3,) in m, tips, and whether the fingers are open."""

    wrist: Array
    index: Tip
    thumb: Tip
    hand_open: bool


@dataclass(frozen=True, slots=True)
class LimbEvidence:
    """What the limbs say of the hand: wrist (3,) in m with covariance (3, 3), elbow (3,), far end of the hand (3,)."""

    wrist: Array
    wrist_covariance: Array
    elbow: Array
    far_end: Array


class HandTracker:
    """Follows a hand with the hand model; its habits are those of one operator and last through losses."""

    def __init__(
        self, initial_pairs: int, right_arm: bool, own: Belief | None = None, scale: float | None = None
    ) -> None:
        """`own` and `scale` are the habits and the size against the average hand that an earlier run has learned."""
        self._initial_pairs = initial_pairs
        self._right_arm = right_arm
        self._habits = Habits(own)
        self._scale = scale
        self._last: tuple[HandFit, Array] | None = None
        self._open = False
        self._turn = np.zeros(3)
        self._searches = self._opinions = 0
        self._costs: deque[float] = deque(maxlen=REMEMBERED_COSTS)

    @property
    def known(self) -> bool:
        """Whether the operator's hand has been learned."""
        return self._habits.learned >= self._initial_pairs

    @property
    def learned(self) -> tuple[float, Belief] | None:
        """The hand's size against the average and its habits, None until they are known."""
        return (self._scale, self._habits.own) if self.known and self._scale is not None else None

    def forget(self) -> None:
        """Start from an unknown pose with the next instant."""
        self._last, self._turn, self._open = None, np.zeros(3), False

    def track(self, views: Sequence[HandView], arm: LimbEvidence) -> HandEstimate | None:
        """The hand seen in the views; None where the model cannot explain the outlines."""
        person = self._person(arm)
        fit = self._fit(views, arm, person)
        if fit.cost > MAX_COST:
            self.forget()
            return None
        if self._last is not None:
            self._turn = rotation_vector(fit.pose.rotation @ self._last[0].pose.rotation.T)
        self._last = fit, arm.wrist
        self._costs.append(fit.cost)
        if self._habits.is_closed(fit.pose.posture) or not self.known:
            self._learn(fit)
        self._open = self._habits.is_open(fit.pose.posture, self._open)
        return _estimate(views, fit, self._open)

    def _learn(self, fit: HandFit) -> None:
        prior = fit.prior
        told = fit.information - prior.information
        told[:3, :3] += prior.information[:3, :3]
        belief = Belief(prior.posture, prior.information[POSE:, POSE:])
        self._habits.learn(fit.pose.posture, belief, posture_information(told))

    def _person(self, arm: LimbEvidence) -> Person:
        to_elbow = arm.elbow - arm.wrist
        length = max(float(np.linalg.norm(to_elbow)), 1e-6)
        if self._scale is None:
            self._scale = length / TYPICAL_FOREARM
        return Person(self._scale, self._right_arm, to_elbow / length)

    def _fit(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        if self._last is None:
            return self._searched(views, arm, person) if self.known else self._first_search(views, arm, person)
        fit = self._followed(views, arm, person)
        other = self._second_opinion(views, arm, person)
        if other.cost < CLEARLY_BETTER * fit.cost:
            fit = other
        usual = median(self._costs)
        if fit.cost > WORSE_FACTOR * usual + WORSE_MARGIN:
            fit = min(fit, self._the_other_way(views, arm, person), key=_cost)
        if fit.cost > BAD_FACTOR * usual + BAD_MARGIN and self._opinions % SEARCH_EVERY == 0:
            fit = min(fit, self._search(views, arm, person), key=_cost)
        return fit if fit.cost <= MAX_COST else min(fit, self._searched(views, arm, person), key=_cost)

    def _first_search(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """All around at first and now and then; between, in case it is no hand that is shown, from a few rotations."""
        step, thorough = self._searches % len(AGAIN_OFFSETS), self._searches % FIRST_SEARCH_EVERY == 0
        self._searches += 1
        effort = FIRST_SEARCH if thorough else replace(QUICK_SEARCH, offset=AGAIN_OFFSETS[step])
        return search_hand(views, arm.far_end, self._prior(arm, self._habits.closed), person, effort)

    def _searched(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """The better of two searches, one of them for an opened hand."""
        return min(self._search(views, arm, person), self._search(views, arm, person), key=_cost)

    def _search(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """From a few rotations, others each time, so that no instant takes long; by turns opened and as usual."""
        self._searches += 1
        turn, opened = divmod(self._searches, 2)
        belief = self._habits.opened if opened else self._habits.closed
        effort = Effort(AGAIN_ROLLS, AGAIN_KEPT, (0.0,), AGAIN_OFFSETS[turn % len(AGAIN_OFFSETS)])
        return search_hand(views, arm.far_end, self._prior(arm, belief), person, effort)

    def _followed(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """From the last pose, moved along with the wrist and turning on."""
        start = self._carried(arm)
        size = float(np.linalg.norm(self._turn))
        rotation = turned(self._turn * min(1.0, MAX_TURN_AHEAD / max(size, 1e-9))) @ start.rotation
        start = replace(start, rotation=rotation)
        prior = self._prior(arm, near_last(self._belief(), start.posture), start)
        return fit_hand(views, start, prior, person, ITERATIONS)

    def _second_opinion(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """From beside the last pose, elsewhere each time: what is followed may be the second best for long."""
        self._opinions += 1
        axis, way = divmod(self._opinions % (2 * len(OPINIONS)), 2)
        turn, change = OPINIONS[axis]
        sign = 1.0 if way else -1.0
        belief = self._belief()
        start = self._carried(arm)
        posture = belief.posture.copy()
        posture[: len(change)] += sign * np.array(change)
        start = replace(start, rotation=start.rotation @ turned(sign * np.array(turn)), posture=posture)
        return fit_hand(views, start, self._prior(arm, belief, start), person, OPINION_ITERATIONS)

    def _belief(self) -> Belief:
        return self._habits.opened if self._open else self._habits.closed

    def _the_other_way(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """From the last rotation with the fingers opened if they were not, or held as usual if they were."""
        belief = self._habits.closed if self._open else self._habits.opened
        start = replace(self._carried(arm), posture=belief.posture)
        return fit_hand(views, start, self._prior(arm, belief, start), person, REFIT_ITERATIONS)

    def _carried(self, arm: LimbEvidence) -> HandPose:
        if self._last is None:
            raise RuntimeError("no hand to carry on")
        fit, wrist = self._last
        return replace(fit.pose, wrist=fit.pose.wrist + arm.wrist - wrist)

    def _prior(self, arm: LimbEvidence, belief: Belief, near: HandPose | None = None) -> Prior:
        information = prior_information(arm.wrist_covariance, belief.information, turn_known=near is not None)
        return Prior(arm.wrist, belief.posture, information, near)


def _estimate(views: Sequence[HandView], fit: HandFit, hand_open: bool) -> HandEstimate:
    contacts = [contact(view, fit.placed, view.outline) for view in views]
    index, thumb = (find_tip(views, contacts, fit.placed, finger) for finger in (INDEX, THUMB))
    return HandEstimate(fit.pose.wrist, index, thumb, hand_open)


def _cost(fit: HandFit) -> float:
    return fit.cost if math.isfinite(fit.cost) else math.inf
