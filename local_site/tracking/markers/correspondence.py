"""Correspondence of spots: one marker are those of several views with a small reprojection error of a common point."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import project
from local_site.tracking.markers.spots import Spots

MAX_CANDIDATES = 14
RIDGE = 1e-12

Members = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Candidates:
    """N candidate markers: points (N, 3) in m, the spot of each view (N, V), -1 for none, and the largest reprojection
    error in px (N,)."""

    points: Array
    members: Members
    residuals: Array

    def __len__(self) -> int:
        return len(self.points)

    def chosen(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> "Candidates":
        """Some of the candidates."""
        return Candidates(self.points[which], self.members[which], self.residuals[which])


def correspond(projections: Sequence[Array], spots: Sequence[Spots], gate_px: float) -> Candidates:
    """All points where spots of two or more views have a reprojection error within the gate.

    A point from two views is completed by the spots of the other views near its projection; of points from the same
    spots only the one with most views is kept, and of more than MAX_CANDIDATES those with most views and least
    residual.
    """
    pairs = _solved(projections, spots, _pairs([len(s) for s in spots]))
    pairs = pairs.chosen(pairs.residuals <= gate_px)
    full = _solved(projections, spots, _completed(projections, spots, pairs, gate_px))
    full = full.chosen(full.residuals <= gate_px)
    both = Candidates(*(np.concatenate([getattr(full, f), getattr(pairs, f)]) for f in Candidates.__slots__))
    kept: list[int] = []
    for k in np.lexsort((both.residuals, -(both.members >= 0).sum(axis=1))).tolist():
        seen = both.members[k] >= 0
        if not any(np.array_equal(both.members[other][seen], both.members[k][seen]) for other in kept):
            kept.append(k)
        if len(kept) == MAX_CANDIDATES:
            break
    return both.chosen(np.array(kept, dtype=np.int64))


def _pairs(counts: Sequence[int]) -> Members:
    """Every two spots of every two views."""
    tables = [np.empty((0, len(counts)), dtype=np.int64)]
    for i, j in combinations(range(len(counts)), 2):
        table = np.full((counts[i] * counts[j], len(counts)), -1, dtype=np.int64)
        table[:, i] = np.repeat(np.arange(counts[i]), counts[j])
        table[:, j] = np.tile(np.arange(counts[j]), counts[i])
        tables.append(table)
    return np.concatenate(tables)


def _completed(projections: Sequence[Array], spots: Sequence[Spots], pairs: Candidates, gate_px: float) -> Members:
    """The members with the nearest spot of every further view added where it is near enough."""
    members = pairs.members.copy()
    for k, (matrix, view) in enumerate(zip(projections, spots, strict=True)):
        if not len(view) or not len(members):
            continue
        distances = np.linalg.norm(project(matrix, pairs.points)[:, None] - view.pixels[None], axis=2)
        nearest = np.argmin(distances, axis=1)
        near = distances[np.arange(len(members)), nearest] <= 2.0 * gate_px
        members[:, k] = np.where((members[:, k] < 0) & near, nearest, members[:, k])
    return members


def _solved(projections: Sequence[Array], spots: Sequence[Spots], members: Members) -> Candidates:
    """The points of these members by linear least squares, thesis equation 3.25, over the views that see them."""
    seen = members >= 0
    pixels = np.zeros((*members.shape, 2))
    for k, view in enumerate(spots):
        pixels[seen[:, k], k] = view.pixels[members[seen[:, k], k]]
    rows = np.stack([m[:2] - pixels[:, k, :, None] * m[2] for k, m in enumerate(projections)], axis=1)
    rows = (rows * seen[..., None, None]).reshape(len(members), 2 * len(projections), 4)
    a, b = rows[..., :3], -rows[..., 3:]
    normal = a.transpose(0, 2, 1) @ a
    ridge = RIDGE * np.trace(normal, axis1=1, axis2=2)[:, None, None] + np.finfo(float).tiny
    points = np.linalg.solve(normal + ridge * np.eye(3), a.transpose(0, 2, 1) @ b)[..., 0]
    residuals = np.zeros(len(members))
    for k, matrix in enumerate(projections):
        depth = points @ matrix[2, :3] + matrix[2, 3]
        safe = np.where(depth > 0, depth, 1.0)[:, None]
        offset = (points @ matrix[:2, :3].T + matrix[:2, 3]) / safe - pixels[:, k]
        distance = np.where(depth > 0, np.linalg.norm(offset, axis=1), np.inf)
        residuals = np.maximum(residuals, np.where(seen[:, k], distance, 0.0))
    return Candidates(points, members, residuals)
