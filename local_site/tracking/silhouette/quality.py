"""Judgement of silhouettes: whether two show the same arm at one instant, and when to doubt or refuse a measurement."""

import math
from collections.abc import Sequence
from itertools import combinations, permutations

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import fundamental_matrix
from local_site.kernels.compiled import compiled
from local_site.tracking.features.features import Features
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.silhouette.joints import Joints, plane_normal
from local_site.tracking.silhouette.limbs import Limbs, unit
from local_site.tracking.tracker import TrackingReason

MAX_MISFIT = 2.5
MAX_ELBOW_SIGMA = 0.10
MAX_WRIST_SIGMA = 0.06
MIN_BEND_SINE = 0.25
MIN_PLANE_SINE = 0.15
MAX_FOLD_COSINE = 0.64
MIN_FORESHORTENING = 0.5


class Tangency:
    """Compares the silhouettes of calibrated views (3, 4): their epipolar tangents must be the same lines.

    A plane through both camera centres that touches the arm touches both silhouettes, so the outermost epipolar lines
    of one view are those of the other, whatever the arm's shape. Views out of sync, a moved camera and exchanged
    pictures violate this.
    """

    def __init__(self, projections: Sequence[Array]) -> None:
        self._of_pairs: dict[tuple[int, int], tuple[Array, Array]] = {}
        for i, j in permutations(range(len(projections)), 2):
            fundamental = fundamental_matrix(projections[i], projections[j])
            self._of_pairs[i, j] = fundamental, np.linalg.svd(fundamental)[2][-1]

    def residual_px(self, seen: Sequence[int], silhouettes: Sequence[Silhouette]) -> float | None:
        """The largest over all pairs of views of the smaller misfit of both tangents, in px; None if none is in view.

        The smaller one, because at a sleeve or the image border the outline is not the arm's own.
        """
        residuals = []
        for (i, first), (j, second) in combinations(zip(seen, silhouettes, strict=True), 2):
            both = [*_misfits(*self._of_pairs[i, j], first, second), *_misfits(*self._of_pairs[j, i], second, first)]
            residuals += [min(both)] if both else []
        return max(residuals, default=None)


def _misfits(fundamental: Array, epipole: Array, first: Silhouette, second: Silhouette) -> list[float]:
    """The distances in px of the second outline from those epipolar tangents of the first that lie within the picture.

    The fundamental matrix (3, 3) is from the first view to the second; the epipole (3,) is in the first.
    """
    ends = first.contour[list(_outermost(first.contour, epipole))]
    usable = ends[~first.touches_border(ends)]
    return [_nearest_side(second.contour, fundamental @ np.array([*end, 1.0])) for end in usable]


@compiled
def _outermost(contour: Array, epipole: Array) -> tuple[int, int]:
    """The outline's pixels (N, 2) on the first and the last line through an epipole (3,)."""
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
    """The distance in px between an outline (N, 2) and a line (3,) that should be tangent to it."""
    low, high = math.inf, -math.inf
    for k in range(len(contour)):
        distance = contour[k, 0] * line[0] + contour[k, 1] * line[1] + line[2]
        low, high = min(low, distance), max(high, distance)
    return min(abs(low), abs(high)) / max(math.sqrt(line[0] ** 2 + line[1] ** 2), 1e-12)


def objection(joints: Joints | None) -> TrackingReason | None:
    """Say why the joints cannot be used at all; None if they can."""
    if joints is None:
        return TrackingReason.NO_ARM
    if joints.misfit > MAX_MISFIT:
        return TrackingReason.OUT_OF_STEP
    if joints.elbow_sigma > MAX_ELBOW_SIGMA or joints.wrist_sigma > MAX_WRIST_SIGMA:
        return TrackingReason.LEFT_OPEN
    return None


def doubts(rig: Rig, views: Limbs, features: Sequence[Features], joints: Joints) -> list[TrackingReason]:
    """List why elbow and wrist are less certain than usual."""
    reasons = []
    bends = [(f.upper_arm.direction, f.forearm.direction) for f in features if f.upper_arm is not None]
    if not bends:
        reasons.append(TrackingReason.NO_UPPER_ARM)
    elif max(abs(float(upper[0] * fore[1] - upper[1] * fore[0])) for upper, fore in bends) < MIN_BEND_SINE:
        reasons.append(TrackingReason.NEARLY_STRAIGHT)
    elif any(float(upper @ fore) > MAX_FOLD_COSINE for upper, fore in bends):
        reasons.append(TrackingReason.FOLDED)
    plane_sine, foreshortening = _sights(views, joints.elbow, joints.wrist)
    if plane_sine < MIN_PLANE_SINE:
        reasons.append(TrackingReason.PARALLEL_TO_BASELINE)
    if foreshortening < MIN_FORESHORTENING:
        reasons.append(TrackingReason.FORESHORTENED)
    if not rig.contains(joints.wrist):
        reasons.append(TrackingReason.OUTSIDE_VOLUME)
    return reasons


@compiled
def _sights(views: Limbs, elbow: Array, wrist: Array) -> tuple[float, float]:
    """The largest sine between the planes through the forearm's lines of two views, and the smallest between the
    forearm and a line of sight to the wrist."""
    planes, arm = np.empty((len(views), 3)), unit(wrist - elbow)
    least_cosine, least_sine = 1.0, 1.0
    for k in range(len(views)):
        matrix = views[k].projection
        planes[k] = plane_normal(matrix, views[k].forearm)
        centre = -np.linalg.solve(np.ascontiguousarray(matrix[:, :3]), np.ascontiguousarray(matrix[:, 3]))
        least_sine = min(least_sine, np.sqrt(max(0.0, 1 - np.sum(unit(wrist - centre) * arm) ** 2)))
        for j in range(k):
            least_cosine = min(least_cosine, abs(np.sum(planes[k] * planes[j])))
    return np.sqrt(max(0.0, 1 - least_cosine**2)), least_sine
