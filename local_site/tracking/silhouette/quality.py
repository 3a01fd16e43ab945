"""When to doubt a measurement, and when to refuse it: report, never guess."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.fingers import Fingers
from local_site.tracking.silhouette.joints import Joints

MAX_MISFIT = 2.5
MAX_ELBOW_SIGMA = 0.10
MAX_WRIST_SIGMA = 0.06
MIN_BEND_SINE = 0.25
MIN_PLANE_SINE = 0.15
VOLUME_MARGIN = 0.15


def objection(joints: Joints | None) -> str:
    """Why the joints cannot be used at all, or an empty string."""
    if joints is None:
        return "the lines of the views do not meet in an arm"
    if joints.misfit > MAX_MISFIT:
        return "the views do not fit together: they are out of sync, or a camera has moved since calibration"
    if joints.elbow_sigma > MAX_ELBOW_SIGMA or joints.wrist_sigma > MAX_WRIST_SIGMA:
        return "the views leave elbow or wrist open: bend the arm and hold it across the view"
    return ""


def doubts(rig: Rig, features: Sequence[Features], joints: Joints, fingers: Fingers) -> list[str]:
    """Why a result is less sure than usual, a sentence each."""
    reasons = []
    if all(f.upper_arm is None for f in features):
        reasons.append("the upper arm does not show enough to place the elbow")
    elif _nearly_straight(features):
        reasons.append("the elbow is nearly straight, so that its place follows from the wrist")
    if _plane_sine(rig.matrices, features) < MIN_PLANE_SINE:
        reasons.append("the forearm is nearly parallel to the line between the cameras")
    if not _inside(rig, joints.wrist):
        reasons.append("the wrist is outside the calibrated volume")
    if fingers.index is None:
        reasons.append("the index tip cannot be told from the other fingers")
    return reasons


def _nearly_straight(features: Sequence[Features]) -> bool:
    """Whether no view shows a bend."""
    sines = [abs(float(f.upper_arm.normal @ f.forearm.direction)) for f in features if f.upper_arm is not None]
    return max(sines, default=0.0) < MIN_BEND_SINE


def _plane_sine(projections: Sequence[Array], features: Sequence[Features]) -> float:
    """The sine between the planes through the forearm's medial line in the first two views."""
    planes = [
        f.forearm.normal @ (m[:2, :3] - np.outer(f.forearm.point, m[2, :3]))
        for m, f in zip(projections[:2], features[:2], strict=True)
    ]
    a, b = (plane / np.linalg.norm(plane) for plane in planes)
    return float(np.linalg.norm(np.cross(a, b)))


def _inside(rig: Rig, point: Array) -> bool:
    low, high = np.array(rig.volume_min), np.array(rig.volume_max)
    margin = VOLUME_MARGIN * (high - low)
    return bool(np.all(point > low - margin) and np.all(point < high + margin))
