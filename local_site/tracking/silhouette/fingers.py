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
from local_site.tracking.silhouette.edges_on_rays import edge_candidates
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
MAX_THUMB_CHANGE = 0.15
MAX_THUMB_STEP = 0.3
NEW_THUMB_COST = 20.0
CLOSING_SIGMA = 0.25
OPENING_SIGMA = 0.06
LEAST_GAP = 0.45
LEAST_FIRST_GAP = 0.3
FINGER = 0.09
BUNDLE = 0.18
MAX_SIDE = 1.8
MAX_INDEX_STEP = 0.15
MAX_LENGTH_CHANGE = 0.2
MAX_TIP_COST = 14.0
MAX_EXTRA_COST = 10.0
RADIAL_COST = 8.0
KNOWN_RADIAL_COST = 3.0


@dataclass(frozen=True, slots=True)
class Fingers:
    """Tips (3,) in m, None where not identified, and whether they were inferred from one view and the hand's shape.

    `hand_open` is this instant's observation.
    """

    index: Array | None
    thumb: Array | None
    thumb_inferred: bool = False
    index_inferred: bool = False
    hand_open: bool = False


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
    costed = with_place_costs(stereo_candidates(projections, features, places), places)
    index, thumb = _ranked_tips(costed, wrist, shape, expected)
    found = _assign(index, thumb, shape)
    if spread:
        return replace(_sure(found, wrist, shape, expected).fingers, hand_open=True)
    rays = None
    if shape.gap is not None:
        rays = tip_rays(projections, features, places, wrist, RAY_REACH * shape.index)
        if found.cost > SINGLE_VIEW_COST:
            trials = _index_from_rays(rays, thumb, wrist, shape, expected)
            trials += _thumb_from_rays(rays, index, wrist, shape, expected)
            found = min([found, *trials], key=_cost)
        found = _sure(found, wrist, shape, expected)
    edges = edge_candidates(projections, features, places, wrist, shape.index)
    tips = costed.joined(_beside(edges, costed, wrist, shape.index))
    index = _ranked_tips(tips, wrist, shape, expected)[0]
    return _index_again(found.fingers, index, rays, wrist, shape, expected)


def _ranked_tips(found: Candidates, wrist: Array, shape: HandShape, expected: Fingers) -> tuple[Candidates, Candidates]:
    """The best candidates for index and thumb."""
    sigma = TYPICAL_SIGMA if shape.gap is None else KNOWN_SIGMA
    index = _ranked(found, wrist, shape.index, expected.index, sigma)
    return index, _ranked(found, wrist, shape.thumb, expected.thumb, sigma)


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


def _beside(edges: Candidates, tips: Candidates, wrist: Array, length: float) -> Candidates:
    """The edges within a few fingers' breadths of a place where tips of both views meet at a finger's length."""
    lengths = np.linalg.norm(tips.points - wrist, axis=1)
    fits = (np.abs(lengths / length - 1) < MAX_LENGTH_CHANGE) & (tips.cost < MAX_TIP_COST)
    apart = np.linalg.norm(edges.points[:, None] - tips.points[fits][None, :], axis=2)
    kept = (apart < BUNDLE * length).any(axis=1)
    return Candidates(edges.points[kept], edges.cost[kept], edges.members[kept])


def _sure(found: _Choice, wrist: Array, shape: HandShape, expected: Fingers) -> _Choice:
    """The choice without its thumb where that breaks the hand's shape, or appears anew without clear evidence."""
    thumb = found.fingers.thumb
    if thumb is None or shape.gap is None:
        return found
    change = abs(float(np.linalg.norm(thumb - wrist)) / shape.thumb - 1)
    anew = expected.thumb is None or float(np.linalg.norm(thumb - expected.thumb)) > MAX_THUMB_STEP * shape.thumb
    if change < MAX_THUMB_CHANGE and not (anew and found.cost > NEW_THUMB_COST):
        return found
    return replace(found, fingers=replace(found.fingers, thumb=None, thumb_inferred=False))


def _index_again(
    fingers: Fingers, index: Candidates, rays: Rays | None, wrist: Array, shape: HandShape, expected: Fingers
) -> Fingers:
    """The fingers with the index chosen once more, now that the thumb tells the sides of the hand."""
    thumb, first = fingers.thumb, fingers.index
    if thumb is None or first is None or not len(index.points):
        return fingers
    origins = [first] if expected.index is None else [first, expected.index]
    away = np.min([np.linalg.norm(index.points - origin, axis=1) for origin in origins], axis=0)
    cost = index.cost + _gap_cost(np.linalg.norm(index.points - thumb, axis=1), shape)
    cost = np.where(away < MAX_INDEX_STEP * shape.index, cost, np.inf)
    if not np.isfinite(cost).any():
        return fingers
    index = _radial(replace(index, cost=cost), wrist, thumb, shape)
    best = int(np.argmin(index.cost))
    if rays is not None and len(rays.points):
        on_rays = _continued(rays.nearest(_anchors(wrist, shape.index, thumb, shape)), expected.index, shape.index)
        nearest = int(np.argmin(on_rays.cost))
        if on_rays.cost[nearest] < index.cost[best]:
            return replace(fingers, index=on_rays.points[nearest], index_inferred=True)
    return replace(fingers, index=index.points[best], index_inferred=False)


def _radial(index: Candidates, wrist: Array, thumb: Array, shape: HandShape) -> Candidates:
    """The candidates with a price for lying beside the finger of a bundle that is nearest to the thumb's side.

    The index is the outermost finger there; lengths alone do not tell it from its neighbour.
    """
    first = int(np.argmin(index.cost))
    tip = index.points[first]
    normal = np.cross(tip - wrist, thumb - wrist) * (1 if shape.right_arm else -1)
    breadth = max(float(np.linalg.norm(normal)), 1e-9) * FINGER * shape.index
    side = (index.points - tip) @ normal / breadth
    near = np.linalg.norm(index.points - tip, axis=1) < BUNDLE * shape.index
    near &= (index.cost < index.cost[first] + MAX_EXTRA_COST) & (side < MAX_SIDE)
    weight = RADIAL_COST if shape.gap is None else KNOWN_RADIAL_COST
    price = weight * np.clip(float(side[near].max()) - side, 0.0, 1.0)
    return replace(index, cost=index.cost + np.where(near, price, price[first]))


def _gap_cost(gap: Array, shape: HandShape) -> Array:
    """Squared deviations of distances between index and thumb; closing the grip is easier than opening it."""
    if shape.gap is None:
        cost: Array = (gap / (NEAREST_FINGER * shape.index / INDEX_PER_FOREARM)) ** 2
        return np.where(gap < LEAST_FIRST_GAP * shape.index, np.inf, cost)
    change = gap / shape.gap - 1
    cost = (change / np.where(change < 0, CLOSING_SIGMA, OPENING_SIGMA)) ** 2
    return np.where(gap < LEAST_GAP * shape.gap, np.inf, cost)


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
