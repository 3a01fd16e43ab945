"""The shape of the hand held like a gripper, learned while it turns.

From one direction a neighbouring finger may stand in for the index without contradiction. When the hand turns, only the
true tip stays at its distances from wrist and thumb on the ray of a visible tip and within the other view's silhouette:
the shape that explains most orientations is the hand's. A neighbour stands in from a finger's breadth away, so the
first shape is never far off.
"""

from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.fingers import Fingers
from local_site.tracking.silhouette.opening import HandShape

MIN_TURN_COSINE = 0.9986
MAX_KEPT = 30
PER_ORIENTATION = 8
LENGTH_SIGMA = 0.04
GAP_SIGMA = 0.04
MIN_ORIENTATIONS = 4
OUTLIER_SHARE = 0.1
STEREO_WEIGHT = 0.1
MAX_CHANGE = 0.06
GAP_RANGE = (0.78, 1.03)
NEARNESS_WEIGHT = 0.5
LEARNED_GAP_SIGMA = 0.05


@dataclass(frozen=True, slots=True)
class _Orientation:
    """One orientation of the hand: direction to the thumb (3,), and distances (N, 2) in m from wrist and thumb.

    `stereo` has those of the places where both views may show the index, with their likelihood, `possible` those of all
    points where a ray may have it.
    """

    direction: Array
    stereo: Array
    likelihood: Array
    possible: Array


class HandModel:
    """Collects orientations of the hand and finds the shape that fits most of them."""

    def __init__(self, shape: HandShape) -> None:
        self.shape = shape
        self._first = shape
        self._orientations: list[_Orientation] = []

    def observe(self, wrist: Array, fingers: Fingers) -> None:
        """Take in a hand about a wrist (3,), if it is held like a gripper and both views show the thumb."""
        thumb, stereo, rays = fingers.thumb, fingers.stereo, fingers.rays
        if fingers.hand_open or fingers.thumb_inferred or thumb is None or stereo is None or rays is None:
            return
        arm = thumb - wrist
        direction = arm / max(float(np.linalg.norm(arm)), 1e-9)
        if any(float(direction @ known.direction) > MIN_TURN_COSINE for known in self._orientations):
            return
        distances = _distances(stereo.points, wrist, thumb)
        low, high = (share * (self._first.gap or self._first.index) for share in GAP_RANGE)
        apart = (distances[:, 1] > low) & (distances[:, 1] < high)
        likely = np.flatnonzero(apart & (np.abs(distances[:, 0] / self._first.index - 1) < MAX_CHANGE))
        order = likely[np.argsort(stereo.cost[likely])][:PER_ORIENTATION]
        possible = _distances(rays.points[rays.allowed], wrist, thumb)
        if not len(order) or not len(possible):
            return
        likelihood = np.exp(-0.5 * stereo.cost[order])
        self._orientations.append(_Orientation(direction, distances[order], likelihood, possible))
        del self._orientations[:-MAX_KEPT]
        if len(self._orientations) >= MIN_ORIENTATIONS:
            self._fit()

    def _fit(self) -> None:
        """Take the hypothesis that most orientations allow; of equals the finger nearer to the thumb."""
        hypotheses = np.concatenate([o.stereo for o in self._orientations])
        sigma = np.array([LENGTH_SIGMA * self.shape.index, GAP_SIGMA * self.shape.index])
        nearness = 1 - hypotheses[:, 1] / (self._first.gap or self._first.index)
        score = NEARNESS_WEIGHT * len(self._orientations) * nearness
        for o in self._orientations:
            score += np.log(OUTLIER_SHARE + _fit_of(hypotheses, o.possible, sigma).max(axis=1))
            score += STEREO_WEIGHT * np.max(o.likelihood * _fit_of(hypotheses, o.stereo, sigma), axis=1)
        length, gap = hypotheses[int(np.argmax(score))]
        self.shape = replace(self.shape, index=float(length), gap=float(gap), gap_sigma=LEARNED_GAP_SIGMA)


def _distances(points: Array, wrist: Array, thumb: Array) -> Array:
    """Distances (N, 2) of points (N, 3) from wrist and thumb (3,)."""
    return np.column_stack([np.linalg.norm(points - origin, axis=1) for origin in (wrist, thumb)])


def _fit_of(hypotheses: Array, distances: Array, sigma: Array) -> Array:
    """How well (H, N), 0 to 1, each of N observed distances (N, 2) fits each hypothesis (H, 2)."""
    squares = np.sum(((hypotheses[:, None] - distances[None, :]) / sigma) ** 2, axis=2)
    fit: Array = np.exp(-0.5 * squares)
    return fit
