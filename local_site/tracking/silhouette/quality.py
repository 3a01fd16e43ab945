"""When to doubt a measurement, and when to refuse it: report, never guess."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.kernels.compiled import compiled
from local_site.tracking.reasons import TrackingReason
from local_site.tracking.silhouette.elbow_depth import unit
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.joints import Joints, plane_normal
from local_site.tracking.silhouette.limbs import Limbs

MAX_MISFIT = 2.5
MAX_ELBOW_SIGMA = 0.10
MAX_WRIST_SIGMA = 0.06
MIN_BEND_SINE = 0.25
MIN_PLANE_SINE = 0.15
MAX_FOLD_COSINE = 0.64
MIN_FORESHORTENING = 0.5
VOLUME_MARGIN = 0.15


def objection(joints: Joints | None) -> TrackingReason | None:
    """Why the joints cannot be used at all."""
    if joints is None:
        return TrackingReason.NO_ARM
    if joints.misfit > MAX_MISFIT:
        return TrackingReason.OUT_OF_STEP
    if joints.elbow_sigma > MAX_ELBOW_SIGMA or joints.wrist_sigma > MAX_WRIST_SIGMA:
        return TrackingReason.LEFT_OPEN
    return None


def doubts(rig: Rig, views: Limbs, features: Sequence[Features], joints: Joints) -> list[TrackingReason]:
    """Why elbow and wrist are less sure than usual."""
    reasons = []
    if all(f.upper_arm is None for f in features):
        reasons.append(TrackingReason.NO_UPPER_ARM)
    elif _nearly_straight(features):
        reasons.append(TrackingReason.NEARLY_STRAIGHT)
    elif any(_folded(f) for f in features):
        reasons.append(TrackingReason.FOLDED)
    plane_sine, share_seen = _sights(views, joints.elbow, joints.wrist)
    if plane_sine < MIN_PLANE_SINE:
        reasons.append(TrackingReason.PARALLEL_TO_BASELINE)
    if share_seen < MIN_FORESHORTENING:
        reasons.append(TrackingReason.FORESHORTENED)
    if not _inside(rig, joints.wrist):
        reasons.append(TrackingReason.OUTSIDE_VOLUME)
    return reasons


def _nearly_straight(features: Sequence[Features]) -> bool:
    """Whether no view shows a bend."""
    pairs = [(f.upper_arm.direction, f.forearm.direction) for f in features if f.upper_arm is not None]
    sines = [abs(float(upper[0] * fore[1] - upper[1] * fore[0])) for upper, fore in pairs]
    return max(sines, default=0.0) < MIN_BEND_SINE


def _folded(view: Features) -> bool:
    return view.upper_arm is not None and float(view.upper_arm.direction @ view.forearm.direction) > MAX_FOLD_COSINE


@compiled
def _sights(views: Limbs, elbow: Array, wrist: Array) -> tuple[float, float]:
    """The largest sine between the planes through the forearm's lines of two views, and the smallest between the
    forearm and a line of sight to the wrist."""
    planes, arm = np.empty((len(views), 3)), unit(wrist - elbow)
    least_cosine, share = 1.0, 1.0
    for k in range(len(views)):
        matrix = views[k].projection
        planes[k] = plane_normal(matrix, views[k].forearm)
        centre = -np.linalg.solve(np.ascontiguousarray(matrix[:, :3]), np.ascontiguousarray(matrix[:, 3]))
        share = min(share, np.sqrt(max(0.0, 1 - np.sum(unit(wrist - centre) * arm) ** 2)))
        for j in range(k):
            least_cosine = min(least_cosine, abs(np.sum(planes[k] * planes[j])))
    return np.sqrt(max(0.0, 1 - least_cosine**2)), share


def _inside(rig: Rig, point: Array) -> bool:
    sides = zip(point.tolist(), rig.volume_min, rig.volume_max, strict=True)
    return all(low - VOLUME_MARGIN * (high - low) < x < high + VOLUME_MARGIN * (high - low) for x, low, high in sides)
