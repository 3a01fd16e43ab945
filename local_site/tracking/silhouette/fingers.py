"""Which places are index and thumb: by length from the wrist, epipolar residual, shape of the hand and continuity.

The thesis (3.2.11.1) takes the tip nearest to the last index tip; lengths and epipolar residuals keep the two from
changing places when the hand turns, and a neighbouring finger from standing in for the index.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.tracking.silhouette.candidates import (
    SINGLE_VIEW_COST,
    Anchor,
    Candidates,
    Rays,
    find_places,
    stereo_candidates,
    tip_rays,
    with_place_costs,
)
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.opening import INDEX_PER_FOREARM, HandShape, hand_reach, is_open, opened

TYPICAL_SIGMA = 0.15
KNOWN_SIGMA = 0.04
MOTION_SIGMA = 0.12
MAX_MOTION_COST = 12.0
NEAREST_FINGER = 0.25
MAX_GAP_DEVIATION = 4.0
KEPT = 16
TRIED = 3
RAY_REACH = 1.2
RAY_GATE = 0.15
MAX_COST = 60.0
NO_THUMB_COST = 32.0


@dataclass(frozen=True, slots=True)
class Fingers:
    """Tips (3,) in m, None where not identified, and whether they were inferred from one view and the hand's shape.

    `hand_open` is this instant's observation; `stereo` are all places where rays
    to tips of both views meet, `rays` those to the prominent tips.
    """

    index: Array | None
    thumb: Array | None
    thumb_inferred: bool = False
    index_inferred: bool = False
    hand_open: bool = False
    stereo: Candidates | None = None
    rays: Rays | None = None


@dataclass(frozen=True, slots=True)
class _Choice:
    """A possible answer and its cost in squared standard deviations."""

    fingers: Fingers
    cost: float


def find_fingers(
    projections: Sequence[Array], features: Sequence[Features], wrist: Array, shape: HandShape, expected: Fingers
) -> Fingers:
    """Index and thumb of a hand seen in two views about a wrist (3,); `expected` are their predicted positions.

    First both from tips that both views show; once the hand's shape is known also one of them from a single view, if
    that fits better.
    """
    projections, features = projections[:2], features[:2]
    hands = [f.hand for f in features]
    reach = hand_reach(projections, features, wrist)
    spread = is_open(features, reach, shape)
    places = [find_places(hand) for hand in hands if hand is not None]
    if len(places) < 2 or not all(len(p.pixels) for p in places):
        return Fingers(None, None, hand_open=spread)
    if spread:
        shape = opened(shape, reach)
    sigma = TYPICAL_SIGMA if shape.gap is None else KNOWN_SIGMA
    stereo = stereo_candidates(projections, features, places)
    costed = with_place_costs(stereo, places)
    index = _ranked(costed, wrist, shape.index, expected.index, sigma)
    thumb = _ranked(costed, wrist, shape.thumb, expected.thumb, sigma)
    found = _assign(index, thumb, shape)
    if shape.gap is None or spread:
        return replace(found.fingers, hand_open=spread, stereo=stereo)
    rays = tip_rays(projections, features, places, wrist, RAY_REACH * shape.index)
    trials = [found]
    if found.cost > SINGLE_VIEW_COST:
        trials += _index_from_rays(rays, thumb, wrist, shape, expected)
        trials += _thumb_from_rays(rays, index, wrist, shape, expected)
    found = min(trials, key=_cost)
    if found.cost > 2 * SINGLE_VIEW_COST:
        found = min(found, _both_from_rays(rays, wrist, shape, expected), key=_cost)
    return replace(found.fingers, hand_open=spread, stereo=stereo, rays=rays)


def _index_from_rays(rays: Rays, thumb: Candidates, wrist: Array, shape: HandShape, expected: Fingers) -> list[_Choice]:
    """The best index on a ray for each of the likeliest thumbs."""
    choices = []
    for j in range(min(TRIED, len(thumb.points))):
        anchors = _anchors(wrist, shape.index, thumb.points[j], shape)
        found = _continued(rays.nearest(anchors), expected.index, shape.index)
        found = _without(found, thumb.members[j])
        if len(found.points):
            i = int(np.argmin(found.cost))
            fingers = Fingers(found.points[i], thumb.points[j], index_inferred=True)
            choices.append(_Choice(fingers, float(found.cost[i] + thumb.cost[j])))
    return choices


def _thumb_from_rays(rays: Rays, index: Candidates, wrist: Array, shape: HandShape, expected: Fingers) -> list[_Choice]:
    """The best thumb on a ray for each of the likeliest index tips."""
    choices = []
    for i in range(min(TRIED, len(index.points))):
        anchors = _anchors(wrist, shape.thumb, index.points[i], shape)
        found = _continued(rays.nearest(anchors), expected.thumb, shape.thumb)
        found = _without(found, index.members[i])
        if len(found.points):
            j = int(np.argmin(found.cost))
            fingers = Fingers(index.points[i], found.points[j], thumb_inferred=True)
            choices.append(_Choice(fingers, float(found.cost[j] + index.cost[i])))
    return choices


def _both_from_rays(rays: Rays, wrist: Array, shape: HandShape, expected: Fingers) -> _Choice:
    """Index and thumb on two rays, where they best keep their distances from the wrist and from each other."""
    best = _Choice(Fingers(None, None), MAX_COST)
    gap = shape.gap if shape.gap is not None else shape.index
    as_index = _ray_costs(rays, wrist, shape.index, expected.index)
    as_thumb = _ray_costs(rays, wrist, shape.thumb, expected.thumb)
    for i in range(len(rays.points)):
        for j in range(len(rays.points)):
            if i == j:
                continue
            apart = np.linalg.norm(rays.points[i][:, None] - rays.points[j][None, :], axis=2)
            cost = as_index[i][:, None] + as_thumb[j][None, :] + ((apart / gap - 1) / shape.gap_sigma) ** 2
            a, b = np.unravel_index(int(np.argmin(cost)), cost.shape)
            total = float(cost[a, b])
            if total < best.cost:
                fingers = Fingers(rays.points[i][a], rays.points[j][b], thumb_inferred=True, index_inferred=True)
                best = _Choice(fingers, total)
    return best


def _ray_costs(rays: Rays, wrist: Array, length: float, before: Array | None) -> Array:
    """Squared deviations (R, S) of the points of all rays as a tip at a length from the wrist."""
    cost = ((np.linalg.norm(rays.points - wrist, axis=2) / length - 1) / KNOWN_SIGMA) ** 2 + rays.cost[:, None]
    if before is None:
        return np.full(cost.shape, np.inf)
    near = np.linalg.norm(rays.points - before, axis=2) < RAY_GATE * length
    result: Array = np.where(rays.allowed & near, cost + _motion_cost(rays.points, before, length), np.inf)
    return result


def _cost(choice: _Choice) -> float:
    return choice.cost


def _anchors(wrist: Array, length: float, other_tip: Array, shape: HandShape) -> tuple[Anchor, Anchor]:
    gap = shape.gap if shape.gap is not None else length
    return Anchor(wrist, length, KNOWN_SIGMA * length), Anchor(other_tip, gap, shape.gap_sigma * gap)


def _with_motion(found: Candidates, before: Array | None, length: float) -> Candidates:
    if before is None:
        return found
    return replace(found, cost=found.cost + _motion_cost(found.points, before, length))


def _continued(found: Candidates, before: Array | None, length: float) -> Candidates:
    """Candidates of a single view where they continue what was seen; without that, one view is not enough."""
    if before is None:
        return replace(found, cost=np.full(len(found.cost), np.inf))
    near = np.linalg.norm(found.points - before, axis=1) < RAY_GATE * length
    return _with_motion(replace(found, cost=np.where(near, found.cost, np.inf)), before, length)


def _motion_cost(points: Array, before: Array, length: float) -> Array:
    """Squared deviations (...) of points (..., 3) from the expected tip, limited so that no error lasts."""
    moved = np.linalg.norm(points - before, axis=-1) / (MOTION_SIGMA * length)
    limited: Array = np.minimum(moved**2, MAX_MOTION_COST)
    return limited


def _without(found: Candidates, members: NDArray[np.int64]) -> Candidates:
    """The candidates that use none of the places of another tip."""
    taken = ((found.members == members) & (found.members >= 0)).any(axis=1)
    return replace(found, cost=np.where(taken, np.inf, found.cost))


def _ranked(found: Candidates, wrist: Array, length: float, before: Array | None, sigma: float) -> Candidates:
    """The best candidates for a tip at a length from the wrist, with their squared deviations as cost."""
    lengths = np.linalg.norm(found.points - wrist, axis=1)
    costed = _with_motion(replace(found, cost=found.cost + ((lengths / length - 1) / sigma) ** 2), before, length)
    best = np.argsort(costed.cost)[:KEPT]
    return Candidates(costed.points[best], costed.cost[best], costed.members[best])


def _assign(index: Candidates, thumb: Candidates, shape: HandShape) -> _Choice:
    """The pair of candidates of least total cost; a thumb may be missing, at a price."""
    nothing = _Choice(Fingers(None, None), MAX_COST)
    if not len(index.points):
        return nothing
    alone = int(np.argmin(index.cost))
    choice = _Choice(Fingers(index.points[alone], None), float(index.cost[alone]) + NO_THUMB_COST)
    if len(thumb.points):
        both = _together(index, thumb, shape)
        i, j = np.unravel_index(int(np.argmin(both)), both.shape)
        pair = _Choice(Fingers(index.points[i], thumb.points[j]), float(both[i, j]))
        choice = min(choice, pair, key=_cost)
    return min(choice, nothing, key=_cost)


def _together(index: Candidates, thumb: Candidates, shape: HandShape) -> Array:
    """Cost (I, T) of every index with every thumb; while the gap is unknown, the nearest finger is preferred."""
    gap = np.linalg.norm(index.points[:, None] - thumb.points[None, :], axis=2)
    if shape.gap is None:
        deviation = gap / (NEAREST_FINGER * shape.index / INDEX_PER_FOREARM)
    else:
        deviation = np.minimum(np.abs(gap / shape.gap - 1) / shape.gap_sigma, MAX_GAP_DEVIATION)
    shared = ((index.members[:, None] == thumb.members[None, :]) & (index.members[:, None] >= 0)).any(axis=2)
    both: Array = index.cost[:, None] + thumb.cost[None, :] + deviation**2
    return np.where(shared, np.inf, both)


def carried(fingers: Fingers, shift: Array) -> Fingers:
    """The fingers moved along with the hand."""
    index, thumb = (None if p is None else p + shift for p in (fingers.index, fingers.thumb))
    return replace(fingers, index=index, thumb=thumb)
