"""When to doubt a measurement, and when to refuse it: report, never guess."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.tracking.reasons import Reason
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.joints import Joints

MAX_MISFIT = 2.5
MAX_ELBOW_SIGMA = 0.10
MAX_WRIST_SIGMA = 0.06
MIN_BEND_SINE = 0.25
MIN_PLANE_SINE = 0.15
MAX_FOLD_COSINE = 0.64
MIN_FORESHORTENING = 0.5
VOLUME_MARGIN = 0.15


def objection(joints: Joints | None) -> Reason | None:
    """Why the joints cannot be used at all."""
    if joints is None:
        return Reason.NO_ARM
    if joints.misfit > MAX_MISFIT:
        return Reason.OUT_OF_STEP
    if joints.elbow_sigma > MAX_ELBOW_SIGMA or joints.wrist_sigma > MAX_WRIST_SIGMA:
        return Reason.LEFT_OPEN
    return None


def doubts(rig: Rig, projections: Sequence[Array], features: Sequence[Features], joints: Joints) -> list[Reason]:
    """Why elbow and wrist are less sure than usual."""
    reasons = []
    if all(f.upper_arm is None for f in features):
        reasons.append(Reason.NO_UPPER_ARM)
    elif _nearly_straight(features):
        reasons.append(Reason.NEARLY_STRAIGHT)
    elif any(_folded(f) for f in features):
        reasons.append(Reason.FOLDED)
    if _plane_sine(projections, features) < MIN_PLANE_SINE:
        reasons.append(Reason.PARALLEL_TO_BASELINE)
    if any(_share_seen(m, joints) < MIN_FORESHORTENING for m in projections):
        reasons.append(Reason.FORESHORTENED)
    if not _inside(rig, joints.wrist):
        reasons.append(Reason.OUTSIDE_VOLUME)
    return reasons


def _nearly_straight(features: Sequence[Features]) -> bool:
    """Whether no view shows a bend."""
    sines = [abs(float(f.upper_arm.normal @ f.forearm.direction)) for f in features if f.upper_arm is not None]
    return max(sines, default=0.0) < MIN_BEND_SINE


def _folded(view: Features) -> bool:
    return view.upper_arm is not None and float(view.upper_arm.direction @ view.forearm.direction) > MAX_FOLD_COSINE


def _share_seen(projection: Array, joints: Joints) -> float:
    """The sine between the forearm and the line of sight."""
    centre = -np.linalg.solve(projection[:, :3], projection[:, 3])
    sight, arm = joints.wrist - centre, joints.wrist - joints.elbow
    across = np.cross(sight, arm)
    return float(np.linalg.norm(across) / max(float(np.linalg.norm(sight) * np.linalg.norm(arm)), 1e-9))


def _plane_sine(projections: Sequence[Array], features: Sequence[Features]) -> float:
    """The largest sine between the planes through the forearm's medial lines of two views."""
    planes = np.array(
        [
            f.forearm.normal @ (m[:2, :3] - np.outer(f.forearm.point, m[2, :3]))
            for m, f in zip(projections, features, strict=True)
        ]
    )
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    cosines = np.abs(planes @ planes.T)
    return float(np.sqrt(max(0.0, 1 - float(cosines.min()) ** 2)))


def _inside(rig: Rig, point: Array) -> bool:
    low, high = np.array(rig.volume_min), np.array(rig.volume_max)
    margin = VOLUME_MARGIN * (high - low)
    return bool(np.all(point > low - margin) and np.all(point < high + margin))
