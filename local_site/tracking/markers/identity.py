"""Which candidate is which marker: an assignment by the distances between the markers and where they were last."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.tracking.markers.correspondence import Candidates

WRIST, INDEX, THUMB = 0, 1, 2
ROLES = ("wrist", "index", "thumb")
SPANS = ((WRIST, INDEX), (WRIST, THUMB), (INDEX, THUMB))
NOBODY = -1

# Relative standard deviations: a hand flexes a little, and opens between index and thumb.
LEARNED_SIGMAS = (0.08, 0.10, 0.20)
TYPICAL_M = (0.170, 0.130, 0.085)
TYPICAL_SIGMAS = (0.25, 0.25, 0.30)
MAX_SIGMAS = 4.0
ORDER_MARGIN = 1.04
PREDICTED_SIGMA_M = 0.020
MAX_SURPRISE = 16.0
ABSENCE_COST = 12.0
UNSEEN_COST = 2.0
RESIDUAL_COST = 4.0
DOUBT = 4.0
SAME_PLACE_M = 0.010


@dataclass(frozen=True, slots=True)
class Spans:
    """The distances in m wrist to index, wrist to thumb and index to thumb, with relative standard deviations."""

    lengths: tuple[float, float, float]
    sigmas: tuple[float, float, float] = LEARNED_SIGMAS


TYPICAL = Spans(TYPICAL_M, TYPICAL_SIGMAS)


@dataclass(frozen=True, slots=True)
class Identity:
    """The candidate of wrist, index and thumb (3,), NOBODY where there is none, and which of them could not be told
    from another explanation that is nearly as likely (3,)."""

    chosen: NDArray[np.int64]
    doubtful: NDArray[np.bool_]


def first_identity(candidates: Candidates, gate_px: float) -> Identity:
    """Who is who without any knowledge of this hand: all three must be there, with the distances of a human hand.

    The wrist is the farthest from the other two, and the thumb is nearer to it than the index.
    """
    return _cheapest(candidates, _costs(candidates, TYPICAL, None, gate_px) + _order_cost(candidates.points))


def next_identity(candidates: Candidates, learned: Spans, expected: Array, gate_px: float) -> Identity:
    """Who is who by the learned distances and the expected places (3, 3) in m, NaN where nothing is expected."""
    return _cheapest(candidates, _costs(candidates, learned, expected, gate_px))


def _costs(candidates: Candidates, spans: Spans, expected: Array | None, gate_px: float) -> Array:
    """The cost (N + 1, N + 1, N + 1) of each choice of wrist, index and thumb; the last choice is NOBODY."""
    count = len(candidates)
    own = np.zeros((3, count + 1))
    own[:, :count] = RESIDUAL_COST * (candidates.residuals / gate_px) ** 2
    own[:, :count] += UNSEEN_COST * (candidates.members < 0).sum(axis=1)
    if expected is not None:
        distances = np.linalg.norm(candidates.points[None] - expected[:, None], axis=2)
        surprise = np.minimum((distances / PREDICTED_SIGMA_M) ** 2, MAX_SURPRISE)
        own[:, :count] += np.nan_to_num(surprise, nan=0.0)
    own[:, count] = ABSENCE_COST
    pairs = [_span_cost(candidates, length, sigma) for length, sigma in zip(spans.lengths, spans.sigmas, strict=True)]
    wrist_index, wrist_thumb, index_thumb = pairs
    total: Array = own[WRIST][:, None, None] + own[INDEX][None, :, None] + own[THUMB][None, None, :]
    return total + wrist_index[:, :, None] + wrist_thumb[:, None, :] + index_thumb[None]


def _span_cost(candidates: Candidates, length: float, sigma: float) -> Array:
    """What the distance of two candidates (N + 1, N + 1) costs; infinite beyond belief, or where they share a spot."""
    count = len(candidates)
    deviation = (_distances(candidates.points) / length - 1.0) / sigma
    cost = np.zeros((count + 1, count + 1))
    impossible = candidates.rivals() | (np.abs(deviation) > MAX_SIGMAS)
    cost[:count, :count] = np.where(impossible, np.inf, deviation**2)
    return cost


def _order_cost(points: Array) -> Array:
    """Infinite for choices (N + 1, N + 1, N + 1) that are not complete or not in the order of a hand's distances."""
    count = len(points)
    apart = _distances(points)
    first, second, last = apart[:, :, None], apart[:, None, :], apart[None]
    ordered = (first > ORDER_MARGIN * second) & (second > ORDER_MARGIN * last)
    cost = np.full((count + 1,) * 3, np.inf)
    cost[:count, :count, :count] = np.where(ordered, 0.0, np.inf)
    return cost


def _cheapest(candidates: Candidates, costs: Array) -> Identity:
    """The choice of least cost, and where a choice that costs little more places a marker elsewhere."""
    count = len(candidates)
    best = np.unravel_index(int(np.argmin(costs)), costs.shape)
    least = float(costs[best])
    if not np.isfinite(least):
        return Identity(np.full(3, NOBODY), np.zeros(3, dtype=bool))
    chosen = np.array(best, dtype=np.int64)
    doubtful = np.zeros(3, dtype=bool)
    for role in np.flatnonzero(chosen < count):
        others = tuple(axis for axis in range(3) if axis != role)
        elsewhere = np.ones(count + 1, dtype=bool)
        apart = np.linalg.norm(candidates.points - candidates.points[chosen[role]], axis=1)
        elsewhere[:count] = apart > SAME_PLACE_M
        doubtful[role] = bool(np.any(costs.min(axis=others)[elsewhere] < least + DOUBT))
    return Identity(np.where(chosen < count, chosen, NOBODY), doubtful)


def _distances(points: Array) -> Array:
    distances: Array = np.linalg.norm(points[:, None] - points[None], axis=2)
    return distances
