"""Tracks the hand between instants: predicts, fits and finds it again; index and thumb with their covariance."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import Effort, HandFit, HandView, fit_hand, search_hand
from local_site.tracking.silhouette.hand_model.habits import Belief, Habits, LimbEvidence, near_last
from local_site.tracking.silhouette.hand_model.skeleton import HandPose, Person, rotation_vector, turned
from local_site.tracking.silhouette.tips import INDEX, THUMB, Tip, find_tips

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
# Rotations about the hand's own axes, rad, each with a change of the first posture angles.
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
    fingers_together: bool


class HandTracker:
    """Tracks a hand with the hand model; the habits learned are one operator's and are kept through losses."""

    def __init__(
        self, initial_pairs: int, right_arm: bool, own: Belief | None = None, scale: float | None = None
    ) -> None:
        """`own` and `scale`, the size relative to the average hand, were learned in an earlier run."""
        self._initial_pairs = initial_pairs
        self._right_arm = right_arm
        self._habits = Habits(own)
        self._scale = scale
        self._last: tuple[HandFit, Array] | None = None
        self._open = self._apart = False
        self._turn = np.zeros(3)
        self._searches = self._opinions = 0
        self._costs: deque[float] = deque(maxlen=REMEMBERED_COSTS)

    @property
    def known(self) -> bool:
        """Return whether the operator's hand has been learned."""
        return self._habits.learned >= self._initial_pairs

    @property
    def learned(self) -> tuple[float, Belief] | None:
        """The hand's size against the average and its habits, None until they are known."""
        return (self._scale, self._habits.own) if self.known and self._scale is not None else None

    def forget(self) -> None:
        """Start from an unknown pose with the next instant."""
        self._last, self._turn = None, np.zeros(3)
        self._open = self._apart = False

    def track(self, views: Sequence[HandView], arm: LimbEvidence) -> HandEstimate | None:
        """The hand seen in the views; None if the model cannot explain the outlines."""
        person = arm.person(self._right_arm, self._scale)
        self._scale = person.scale
        fit = self._fit(views, arm, person)
        if fit.cost > MAX_COST:
            self.forget()
            return None
        if self._last is not None:
            self._turn = rotation_vector(fit.pose.rotation @ self._last[0].pose.rotation.T)
        self._last = fit, arm.wrist
        self._costs.append(fit.cost)
        if self._habits.is_closed(fit.pose.posture) or not self.known:
            self._habits.learn_fit(fit)
        self._open = self._habits.is_open(fit.pose.posture, self._open)
        self._apart = self._habits.are_apart(fit.pose.posture, self._apart)
        index, thumb = find_tips(views, fit.spheres, (INDEX, THUMB))
        return HandEstimate(fit.pose.wrist, index, thumb, self._open, fingers_together=not self._apart)

    def _fit(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        if self._last is None:
            return self._searched(views, arm, person) if self.known else self._first_search(views, arm, person)
        last, wrist = self._last
        carried = last.pose._replace(wrist=last.pose.wrist + arm.wrist - wrist)
        fit = self._followed(views, arm, person, carried)
        other = self._second_opinion(views, arm, person, carried)
        if other.cost < CLEARLY_BETTER * fit.cost:
            fit = other
        usual = median(self._costs)
        if fit.cost > WORSE_FACTOR * usual + WORSE_MARGIN:
            # From the last rotation with the fingers opened if they were closed, or as usual if they were open.
            belief = self._habits.closed if self._open else self._habits.opened
            start = carried._replace(posture=belief.posture)
            fit = min(fit, fit_hand(views, start, arm.prior(belief, start), person, REFIT_ITERATIONS), key=_cost)
        if fit.cost > BAD_FACTOR * usual + BAD_MARGIN and self._opinions % SEARCH_EVERY == 0:
            fit = min(fit, self._search(views, arm, person), key=_cost)
        return fit if fit.cost <= MAX_COST else min(fit, self._searched(views, arm, person), key=_cost)

    def _first_search(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """From all rotations every FIRST_SEARCH_EVERY times; otherwise from a few, to bound the time taken."""
        step, thorough = self._searches % len(AGAIN_OFFSETS), self._searches % FIRST_SEARCH_EVERY == 0
        self._searches += 1
        effort = FIRST_SEARCH if thorough else replace(QUICK_SEARCH, offset=AGAIN_OFFSETS[step])
        return search_hand(views, arm.far_end, arm.prior(self._habits.closed), person, effort)

    def _searched(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """The better of two searches, one of them for an opened hand."""
        return min(self._search(views, arm, person), self._search(views, arm, person), key=_cost)

    def _search(self, views: Sequence[HandView], arm: LimbEvidence, person: Person) -> HandFit:
        """From a few rotations, different each time, to bound the time taken; alternately opened and as usual."""
        self._searches += 1
        turn, opened = divmod(self._searches, 2)
        belief = self._habits.opened if opened else self._habits.closed
        effort = Effort(AGAIN_ROLLS, AGAIN_KEPT, (0.0,), AGAIN_OFFSETS[turn % len(AGAIN_OFFSETS)])
        return search_hand(views, arm.far_end, arm.prior(belief), person, effort)

    def _followed(self, views: Sequence[HandView], arm: LimbEvidence, person: Person, carried: HandPose) -> HandFit:
        """From the last pose, moved with the wrist, at constant angular velocity."""
        size = float(np.linalg.norm(self._turn))
        rotation = turned(self._turn * min(1.0, MAX_TURN_AHEAD / max(size, 1e-9))) @ carried.rotation
        start = carried._replace(rotation=rotation)
        prior = arm.prior(near_last(self._belief(), start.posture), start)
        return fit_hand(views, start, prior, person, ITERATIONS)

    def _second_opinion(
        self, views: Sequence[HandView], arm: LimbEvidence, person: Person, carried: HandPose
    ) -> HandFit:
        """From a start near the last pose, different each time: tracking may stay in a local minimum otherwise."""
        self._opinions += 1
        axis, positive = divmod(self._opinions % (2 * len(OPINIONS)), 2)
        turn, change = OPINIONS[axis]
        sign = 1.0 if positive else -1.0
        belief = self._belief()
        posture = belief.posture.copy()
        posture[: len(change)] += sign * np.array(change)
        start = carried._replace(rotation=carried.rotation @ turned(sign * np.array(turn)), posture=posture)
        return fit_hand(views, start, arm.prior(belief, start), person, OPINION_ITERATIONS)

    def _belief(self) -> Belief:
        return self._habits.opened if self._open else self._habits.closed


def _cost(fit: HandFit) -> float:
    return fit.cost if math.isfinite(fit.cost) else math.inf
