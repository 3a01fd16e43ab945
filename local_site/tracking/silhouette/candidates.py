"""Where a finger tip may be in 3D: tips paired between two views, and tips of one view at known distances."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import project, triangulate_many
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.hand import Hand

SAME_PLACE = 0.08
MAX_RESIDUAL = 0.5
RESIDUAL_SIGMA = 0.06
CORNER_COST = 1.5
UNEXPLAINED_COST = 8.0
BLUNT_COST = 10.0
SHARP_ANGLE = math.radians(105.0)
BLUNT_ANGLE = math.radians(135.0)
CLEAR_PROMINENCE = 0.3
RAYS_PER_VIEW = 5
SINGLE_VIEW_COST = 10.0
SAMPLES = 40
FINE_SAMPLES = 17


@dataclass(frozen=True, slots=True)
class Candidates:
    """N possible places of a tip: points (N, 3) in m, their cost so far (N,), and the places in each view (N, 2) that
    they use, -1 where a view does not show them."""

    points: Array
    cost: Array
    members: NDArray[np.int64]

    @property
    def stereo(self) -> NDArray[np.bool_]:
        """Which candidates both views show (N,)."""
        return np.asarray((self.members >= 0).all(axis=1), dtype=np.bool_)

    def joined(self, other: "Candidates") -> "Candidates":
        """These candidates and others."""
        return Candidates(
            np.concatenate([self.points, other.points]),
            np.concatenate([self.cost, other.cost]),
            np.concatenate([self.members, other.members]),
        )


@dataclass(frozen=True, slots=True)
class Anchor:
    """A point (3,) and the distance that a tip keeps from it, with its standard deviation, in m."""

    point: Array
    distance: float
    sigma: float


@dataclass(frozen=True, slots=True)
class Places:
    """The tip-like places of one view: pixels (N, 2), and what each costs (N,): the more a tip stands out, the less it
    may be left unexplained; corners are less sure than tips."""

    pixels: Array
    cost: Array


def find_places(hand: Hand) -> Places:
    """Prominent tips of a hand, then the corners that are not at one of them."""
    tips = np.array([tip.point for tip in hand.tips]).reshape(-1, 2)
    apart = np.hypot(*(hand.corners[:, None] - tips[None, :]).transpose(2, 0, 1)) > SAME_PLACE * hand.length
    corners = hand.corners[apart.all(axis=1)]
    unexplained = [
        UNEXPLAINED_COST * max(0.0, 1 - tip.prominence / CLEAR_PROMINENCE)
        + BLUNT_COST * min(max((tip.angle - SHARP_ANGLE) / (BLUNT_ANGLE - SHARP_ANGLE), 0.0), 1.0)
        for tip in hand.tips
    ]
    cost = np.concatenate([unexplained, np.full(len(corners), UNEXPLAINED_COST + CORNER_COST)])
    return Places(np.concatenate([tips, corners]), cost)


def stereo_candidates(
    projections: Sequence[Array], features: Sequence[Features], places: Sequence[Places]
) -> Candidates:
    """All pairings of places of two views whose rays nearly meet."""
    counts = [len(p.pixels) for p in places]
    members = np.indices((counts[0], counts[1])).reshape(2, -1).T
    pixels = np.stack([places[k].pixels[members[:, k]] for k in range(2)], axis=1)
    points = triangulate_many(projections, pixels)
    residuals = np.zeros(len(points))
    for k, (matrix, view) in enumerate(zip(projections, features, strict=True)):
        residuals += np.sum((project(matrix, points) - pixels[:, k]) ** 2, axis=1) / view.half_width**2
    near = residuals < MAX_RESIDUAL**2
    return Candidates(points[near], residuals[near] / RESIDUAL_SIGMA**2, members[near])


def with_place_costs(found: Candidates, places: Sequence[Places]) -> Candidates:
    """Stereo candidates with the costs of the places that they use."""
    return replace(found, cost=found.cost + sum(places[k].cost[found.members[:, k]] for k in range(2)))


@dataclass(frozen=True, slots=True)
class Rays:
    """The rays of the likeliest tips of either view, sampled about the hand where the other view's silhouette allows.

    Points (R, S, 3) in m, whether the other view has the arm there (R, S), what taking each ray costs (R,), and the
    places as in Candidates (R, 2).
    """

    points: Array
    allowed: NDArray[np.bool_]
    cost: Array
    members: NDArray[np.int64]

    def nearest(self, anchors: Sequence[Anchor]) -> Candidates:
        """On each ray the allowed point that best keeps its distances to the anchors, refined between the samples."""
        if not len(self.points):
            return Candidates(np.empty((0, 3)), np.empty(0), np.empty((0, 2), dtype=np.int64))
        cost = np.where(self.allowed, _deviation(self.points, anchors), np.inf)
        rows = np.arange(len(cost))
        best = np.clip(np.argmin(cost, axis=1), 1, cost.shape[1] - 2)
        before, after = self.points[rows, best - 1], self.points[rows, best + 1]
        steps = np.linspace(0.0, 1.0, FINE_SAMPLES)[:, None]
        fine = before[:, None] + (after - before)[:, None] * steps
        deviation = _deviation(fine, anchors)
        finest = np.argmin(deviation, axis=1)
        total = np.where(np.isfinite(cost[rows, best]), deviation[rows, finest] + self.cost, np.inf)
        return Candidates(fine[rows, finest], total, self.members)


def tip_rays(
    projections: Sequence[Array], features: Sequence[Features], places: Sequence[Places], wrist: Array, reach: float
) -> Rays:
    """The rays of the likeliest tips within `reach` m of the wrist (3,)."""
    lines, allowed, cost, members = [], [], [], []
    depths = np.linspace(-reach, reach, SAMPLES)
    for k, place in enumerate(places):
        inverse = np.linalg.inv(projections[k][:, :3])
        centre = -inverse @ projections[k][:, 3]
        chosen = np.argsort(place.cost)[:RAYS_PER_VIEW]
        rays = np.column_stack([place.pixels[chosen], np.ones(len(chosen))]) @ inverse.T
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        along = (rays @ (wrist - centre))[:, None] + depths
        lines.append(centre + along[..., None] * rays[:, None])
        inside = features[1 - k].silhouette.contains(project(projections[1 - k], lines[-1]).reshape(-1, 2))
        allowed.append(inside.reshape(-1, SAMPLES))
        cost.append(SINGLE_VIEW_COST + place.cost[chosen])
        unseen = np.full(len(chosen), -1)
        members.append(np.column_stack([chosen, unseen] if k == 0 else [unseen, chosen]))
    return Rays(np.concatenate(lines), np.concatenate(allowed), np.concatenate(cost), np.concatenate(members))


def _deviation(points: Array, anchors: Sequence[Anchor]) -> Array:
    """Squared deviations (...) of points (..., 3) from the anchors' distances."""
    total = np.zeros(points.shape[:-1])
    for anchor in anchors:
        total += ((np.linalg.norm(points - anchor.point, axis=-1) - anchor.distance) / anchor.sigma) ** 2
    return total
