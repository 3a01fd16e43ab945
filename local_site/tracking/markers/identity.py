"""Assigns candidates to markers, by the distances between the markers and their expected positions."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.tracking.markers.correspondence import Candidates

WRIST, INDEX, THUMB = 0, 1, 2
ROLES = ("wrist", "index", "thumb")
Triple = tuple[float, float, float]
SPANS = ((WRIST, INDEX), (WRIST, THUMB), (INDEX, THUMB))
NO_CANDIDATE = -1

# Relative standard deviations of the distances of a hand in its U shape, and the limits that no hand exceeds.
LEARNED_SIGMAS = (0.02, 0.02, 0.03)
LEARNED_LIMITS = ((0.75, 1.3), (0.65, 1.4), (0.2, 2.2))
TYPICAL_M = (0.170, 0.130, 0.085)
TYPICAL_SIGMAS = (0.25, 0.25, 0.30)
TYPICAL_LIMITS = ((0.5, 1.7), (0.5, 1.7), (0.3, 2.0))
ORDER_MARGIN = 1.08
PREDICTED_SIGMA_M = 0.020
MAX_DEVIATION = 6.0
MAX_SURPRISE = 24.0
UNEXPECTED_COST = 8.0
ABSENCE_COST = 22.0
UNSEEN_COST = 2.0
RESIDUAL_COST = 4.0
DOUBT = 4.0
SAME_PLACE_M = 0.010


@dataclass(frozen=True, slots=True)
class Spans:
    """The distances in m wrist to index, wrist to thumb and index to thumb, with relative standard deviations and
    relative lower and upper limits."""

    lengths: Triple
    sigmas: Triple = LEARNED_SIGMAS
    limits: tuple[tuple[float, float], ...] = LEARNED_LIMITS


TYPICAL = Spans(TYPICAL_M, TYPICAL_SIGMAS, TYPICAL_LIMITS)


@dataclass(frozen=True, slots=True)
class MarkerIdentity:
    """The candidate of wrist, index and thumb (3,), or NO_CANDIDATE, and which of them are ambiguous (3,):
    another assignment is nearly as likely."""

    chosen: NDArray[np.int64]
    doubtful: NDArray[np.bool_]


def first_identity(candidates: Candidates, gate_px: float) -> MarkerIdentity:
    """The assignment without any knowledge of this hand: all three must be visible, at a human hand's distances.

    The wrist is the farthest from the other two, and the thumb is nearer to it than the index.
    """
    count = len(candidates)
    apart = _distances(candidates.points)
    first, second, last = apart[:, :, None], apart[:, None, :], apart[None]
    ordered = (first > ORDER_MARGIN * second) & (second > ORDER_MARGIN * last)
    order_cost = np.full((count + 1,) * 3, np.inf)
    order_cost[:count, :count, :count] = np.where(ordered, 0.0, np.inf)
    return _cheapest(candidates, _costs(candidates, TYPICAL, None, gate_px) + order_cost)


def next_identity(candidates: Candidates, learned: Spans, expected: Array, gate_px: float) -> MarkerIdentity:
    """The assignment by the learned distances and the expected positions (3, 3) in m, NaN where none is expected."""
    return _cheapest(candidates, _costs(candidates, learned, expected, gate_px))


def _costs(candidates: Candidates, spans: Spans, expected: Array | None, gate_px: float) -> Array:
    """The cost (N + 1, N + 1, N + 1) of each choice of wrist, index and thumb; the last choice is NO_CANDIDATE.

    Three markers at the right distances are accepted anywhere; fewer only near their expected positions.
    """
    shape = _shape_cost(candidates, spans)
    if expected is None:
        return shape + _own_cost(candidates, np.zeros((3, len(candidates))), gate_px)
    distances = np.linalg.norm(candidates.points[None] - expected[:, None], axis=2)
    surprise = np.nan_to_num((distances / PREDICTED_SIGMA_M) ** 2, nan=UNEXPECTED_COST)
    cost = shape + _own_cost(candidates, np.minimum(surprise, MAX_SURPRISE), gate_px)
    complete = shape + _own_cost(candidates, np.minimum(surprise, UNEXPECTED_COST), gate_px)
    cost[:-1, :-1, :-1] = complete[:-1, :-1, :-1]
    return cost


def _own_cost(candidates: Candidates, surprise: Array, gate_px: float) -> Array:
    """The cost of the choices apart from distances; `surprise` (3, N) is each one's squared deviation in sigmas."""
    own = np.full((3, len(candidates) + 1), ABSENCE_COST)
    unseen = (candidates.members < 0).sum(axis=1)
    own[:, :-1] = surprise + RESIDUAL_COST * (candidates.residuals / gate_px) ** 2 + UNSEEN_COST * unseen
    total: Array = own[WRIST][:, None, None] + own[INDEX][None, :, None] + own[THUMB][None, None, :]
    return total


def _shape_cost(candidates: Candidates, spans: Spans) -> Array:
    """The cost of the distances between the markers; infinite beyond the limits, or for two with a common spot.

    It grows quadratically near the known distance, then logarithmically up to a maximum (Cauchy): an opening hand
    changes its shape, but while it keeps it, small differences identify its markers.
    """
    count, members, distances = len(candidates), candidates.members, _distances(candidates.points)
    rivals = ((members[:, None] == members[None]) & (members[:, None] >= 0)).any(axis=2)
    costs = np.zeros((len(SPANS), count + 1, count + 1))
    for cost, length, sigma, (low, high) in zip(costs, spans.lengths, spans.sigmas, spans.limits, strict=True):
        relative = distances / length
        impossible = rivals | (relative < low) | (relative > high)
        deviation = np.minimum(2.0 * np.log1p(0.5 * ((relative - 1.0) / sigma) ** 2), MAX_DEVIATION)
        cost[:count, :count] = np.where(impossible, np.inf, deviation)
    wrist_index, wrist_thumb, index_thumb = costs
    total: Array = wrist_index[:, :, None] + wrist_thumb[:, None, :] + index_thumb[None]
    return total


def _cheapest(candidates: Candidates, costs: Array) -> MarkerIdentity:
    """The choice of least cost; a marker that a choice of little more cost puts elsewhere is doubtful."""
    count = len(candidates)
    best = np.unravel_index(int(np.argmin(costs)), costs.shape)
    least = float(costs[best])
    if not np.isfinite(least):
        return MarkerIdentity(np.full(3, NO_CANDIDATE), np.zeros(3, dtype=bool))
    chosen = np.array(best, dtype=np.int64)
    doubtful = np.zeros(3, dtype=bool)
    for role in np.flatnonzero(chosen < count):
        others = tuple(axis for axis in range(3) if axis != role)
        elsewhere = np.ones(count + 1, dtype=bool)
        apart = np.linalg.norm(candidates.points - candidates.points[chosen[role]], axis=1)
        elsewhere[:count] = apart > SAME_PLACE_M
        doubtful[role] = bool(np.any(costs.min(axis=others)[elsewhere] < least + DOUBT))
    return MarkerIdentity(np.where(chosen < count, chosen, NO_CANDIDATE), doubtful)


def _distances(points: Array) -> Array:
    distances: Array = np.linalg.norm(points[:, None] - points[None], axis=2)
    return distances
