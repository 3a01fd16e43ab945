"""Whether two silhouettes are of the same arm at the same instant: their epipolar tangents must be the same lines.

A plane through both camera centres that touches the arm touches both silhouettes, so the outermost epipolar lines of
one view are those of the other, whatever the arm's shape. Skew, a moved camera and exchanged pictures break this.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import fundamental_matrix
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.contour import Silhouette


@dataclass(frozen=True, slots=True)
class _Epipolar:
    """The fundamental matrix (3, 3) from one view to another, and where the first sees the other's centre (3,)."""

    fundamental: Array
    epipole: Array

    @classmethod
    def of(cls, first: Array, second: Array) -> Self:
        fundamental = fundamental_matrix(first, second)
        return cls(fundamental, np.linalg.svd(fundamental)[2][-1])


class Tangency:
    """Compares the silhouettes of calibrated views (3, 4) pair by pair."""

    def __init__(self, projections: Sequence[Array]) -> None:
        self._of_pairs = {
            (i, j): _Epipolar.of(projections[i], projections[j])
            for i in range(len(projections))
            for j in range(len(projections))
            if i != j
        }

    def residual_px(self, seen: Sequence[int], silhouettes: Sequence[Silhouette]) -> float | None:
        """The largest over all pairs of views of the smaller misfit of both tangents, in px; None if none is in view.

        The smaller one, because the arm ends at a sleeve or at the border, where its outline is not its own.
        """
        residuals = []
        for a, i in enumerate(seen):
            for b, j in enumerate(seen):
                if i < j:
                    first, second = silhouettes[a], silhouettes[b]
                    both = [
                        *_misfits(self._of_pairs[i, j], first, second),
                        *_misfits(self._of_pairs[j, i], second, first),
                    ]
                    residuals += [min(both)] if both else []
        return max(residuals, default=None)


def _misfits(views: _Epipolar, first: Silhouette, second: Silhouette) -> list[float]:
    """How far, in px, the second outline is from the epipolar tangents of the first that lie within the picture."""
    ends = first.contour[list(_outermost(first.contour, views.epipole))]
    usable = ends[~first.touches_border(ends)]
    return [_nearest_side(second.contour, views.fundamental @ np.array([*end, 1.0])) for end in usable]


@compiled
def _outermost(contour: Array, epipole: Array) -> tuple[int, int]:
    """The outline's pixels (N, 2) through which the first and the last line from a pole (3,) run."""
    x, y = 0.0, 0.0
    for k in range(len(contour)):
        x, y = x + contour[k, 0] / len(contour), y + contour[k, 1] / len(contour)
    ux, uy = epipole[0] - epipole[2] * x, epipole[1] - epipole[2] * y
    length = max(math.sqrt(ux * ux + uy * uy), 1e-12)
    ux, uy = ux / length, uy / length
    first, last, low, high = 0, 0, math.inf, -math.inf
    for k in range(len(contour)):
        px, py = contour[k]
        towards = (epipole[0] - epipole[2] * px) * ux + (epipole[1] - epipole[2] * py) * uy
        order = (ux * (py - y) - uy * (px - x)) / towards
        if order < low:
            first, low = k, order
        if order > high:
            last, high = k, order
    return first, last


@compiled
def _nearest_side(contour: Array, line: Array) -> float:
    """How far an outline (N, 2) reaches beyond, or stays short of, a line (3,) that should touch it, in px."""
    low, high = math.inf, -math.inf
    for k in range(len(contour)):
        distance = contour[k, 0] * line[0] + contour[k, 1] * line[1] + line[2]
        low, high = min(low, distance), max(high, distance)
    return min(abs(low), abs(high)) / max(math.sqrt(line[0] ** 2 + line[1] ** 2), 1e-12)
