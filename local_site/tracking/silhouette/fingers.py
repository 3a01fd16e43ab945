"""Which tips are index and thumb: by length from the wrist, epipolar residual, shape of the hand and continuity.

The thesis (3.2.11.1) asks for the tip nearest to the last index tip; lengths and epipolar residuals keep the two from
changing places when the hand turns.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import project
from local_site.tracking.silhouette.features import Features

RESIDUAL_SIGMA = 0.12
MAX_RESIDUAL = 0.7
LENGTH_SIGMA = 0.12
SHAPE_SIGMA = 0.25
MOTION_SIGMA = 0.25
MAX_COST = 36.0
NO_THUMB_COST = 16.0
INDEX_PER_FOREARM = 0.66
THUMB_PER_FOREARM = 0.52
GAP_PER_FOREARM = 0.34


@dataclass(frozen=True, slots=True)
class HandShape:
    """Distances in m: wrist to index tip, wrist to thumb tip, index tip to thumb tip."""

    index: float
    thumb: float
    gap: float


@dataclass(frozen=True, slots=True)
class Fingers:
    """Tips (3,) in m, None where not identified, and the tip's pixel (2,) in each view."""

    index: Array | None
    thumb: Array | None
    index_pixels: tuple[Array, ...] = ()
    thumb_pixels: tuple[Array, ...] = ()


@dataclass(frozen=True, slots=True)
class _Pairs:
    """All N pairings of a tip in one view with a tip in the other: points (N, 3), pixels (N, 2, 2), residuals in
    half widths (N,), and which tips were paired (N, 2)."""

    points: Array
    pixels: Array
    residuals: Array
    members: Array


def typical_shape(forearm_length: float) -> HandShape:
    """The shape of a hand held like a gripper, by the proportions of the body."""
    return HandShape(
        INDEX_PER_FOREARM * forearm_length, THUMB_PER_FOREARM * forearm_length, GAP_PER_FOREARM * forearm_length
    )


def find_fingers(
    projections: Sequence[Array],
    features: Sequence[Features],
    wrist: Array,
    shape: HandShape,
    expected: Fingers,
) -> Fingers:
    """Index and thumb of a hand seen in two views about a wrist (3,); `expected` are their predicted positions."""
    hands = [f.hand for f in features[:2]]
    if any(hand is None or not hand.tips for hand in hands):
        return Fingers(None, None)
    pairs = _pair(projections, features)
    spread = any(hand is not None and hand.spread for hand in hands)
    stretch = 2.0 if spread else 1.0
    index_cost = _cost(pairs, wrist, shape.index, expected.index, stretch)
    thumb_cost = _cost(pairs, wrist, shape.thumb, expected.thumb, stretch)
    return _assign(pairs, index_cost, thumb_cost, shape, stretch)


def _pair(projections: Sequence[Array], features: Sequence[Features]) -> _Pairs:
    tips = [np.array([tip.point for tip in f.hand.tips]) for f in features[:2] if f.hand is not None]
    members = np.array([(i, j) for i in range(len(tips[0])) for j in range(len(tips[1]))])
    pixels = np.stack([tips[0][members[:, 0]], tips[1][members[:, 1]]], axis=1)
    points = triangulate_many(projections[:2], pixels)
    half_width = np.array([f.half_width for f in features[:2]])
    squares = [np.sum((project(m, points) - pixels[:, k]) ** 2, axis=1) for k, m in enumerate(projections[:2])]
    residuals = np.sqrt(np.mean(np.array(squares) / half_width[:, None] ** 2, axis=0))
    return _Pairs(points, pixels, residuals, members)


def triangulate_many(projections: Sequence[Array], pixels: Array) -> Array:
    """Points (N, 3) in m from pixels (N, V, 2) in V views, each by linear least squares (thesis equation 3.25)."""
    rows = np.concatenate([m[:2] - pixels[:, k, :, None] * m[2] for k, m in enumerate(projections)], axis=1)
    a, b = rows[..., :3], -rows[..., 3:]
    at = a.transpose(0, 2, 1)
    points: Array = np.linalg.solve(at @ a, at @ b)[..., 0]
    return points


def _cost(pairs: _Pairs, wrist: Array, length: float, expected: Array | None, stretch: float) -> Array:
    """Squared deviations (N,) of each pair as the tip at a length from the wrist."""
    lengths = np.linalg.norm(pairs.points - wrist, axis=1)
    cost = (pairs.residuals / RESIDUAL_SIGMA) ** 2 + ((lengths / length - 1) / (LENGTH_SIGMA * stretch)) ** 2
    if expected is not None:
        moved = np.linalg.norm(pairs.points - expected, axis=1)
        cost = cost + (moved / (MOTION_SIGMA * length * stretch)) ** 2
    result: Array = np.where(pairs.residuals < MAX_RESIDUAL, cost, np.inf)
    return result


def _assign(pairs: _Pairs, index_cost: Array, thumb_cost: Array, shape: HandShape, stretch: float) -> Fingers:
    """The pair of pairs of least total cost; a thumb may be missing, at a price."""
    gap = np.linalg.norm(pairs.points[:, None] - pairs.points[None, :], axis=2)
    both = index_cost[:, None] + thumb_cost[None, :] + ((gap / shape.gap - 1) / (SHAPE_SIGMA * stretch)) ** 2
    shared = (pairs.members[:, None] == pairs.members[None, :]).any(axis=2)
    both = np.where(shared, np.inf, both)
    i, j = np.unravel_index(int(np.argmin(both)), both.shape)
    alone = int(np.argmin(index_cost))
    if float(both[i, j]) < float(index_cost[alone]) + NO_THUMB_COST:
        return Fingers(pairs.points[i], pairs.points[j], tuple(pairs.pixels[i]), tuple(pairs.pixels[j]))
    if float(index_cost[alone]) < MAX_COST:
        return Fingers(pairs.points[alone], None, tuple(pairs.pixels[alone]))
    return Fingers(None, None)
