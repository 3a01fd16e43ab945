"""Whether two silhouettes are of the same arm at the same instant: their epipolar tangents must be the same lines.

A plane through both camera centres that touches the arm touches both silhouettes, so the outermost epipolar lines of
one view are those of the other, whatever the arm's shape. Skew, a moved camera and exchanged pictures break this.
"""

import math
from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import fundamental_matrix
from local_site.tracking.silhouette.contour import Silhouette


class Tangency:
    """Compares the silhouettes of calibrated views (3, 4) pair by pair."""

    def __init__(self, projections: Sequence[Array]) -> None:
        self._of_pairs = {
            (i, j): fundamental_matrix(projections[i], projections[j])
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


def _misfits(fundamental: Array, first: Silhouette, second: Silhouette) -> list[float]:
    """How far, in px, the second outline is from the epipolar tangents of the first that lie within the picture."""
    contour = first.contour
    epipole = np.linalg.svd(fundamental)[2][-1]
    middle = contour.mean(axis=0)
    towards = epipole[:2] - epipole[2] * middle
    towards = towards / max(math.hypot(*towards), 1e-12)
    across = towards[0] * (contour[:, 1] - middle[1]) - towards[1] * (contour[:, 0] - middle[0])
    order = across / ((epipole[:2] - epipole[2] * contour) @ towards)
    ends = contour[[int(np.argmin(order)), int(np.argmax(order))]]
    usable = ends[~first.touches_border(ends)]
    return [_nearest_side(fundamental @ np.array([*end, 1.0]), second) for end in usable]


def _nearest_side(line: Array, silhouette: Silhouette) -> float:
    """How far an outline reaches beyond, or stays short of, a line that should touch it, in px."""
    distances = (silhouette.contour @ line[:2] + line[2]) / max(math.hypot(*line[:2]), 1e-12)
    return min(abs(float(distances.max())), abs(float(distances.min())))
