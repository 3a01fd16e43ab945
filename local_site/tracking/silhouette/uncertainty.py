"""How sure elbow and wrist are: the variances of what errs, each along the direction in which it acts.

The sizes are differences between people and the models of them, which cameras do not average out. They were fitted on
rendered arms of three builds and checked on others and on recordings, so that the normalised error squared is near 1.
"""

import numpy as np

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.elbow_depth import px_per_m, unit
from local_site.tracking.silhouette.joints import Joints
from local_site.tracking.silhouette.limbs import Limbs

# variances of the limbs' lines as shares of those that balance them in the least squares
ELBOW_LINES, WRIST_LINES = 0.3, 0.5
# half a limb's width that is bone and skin in everybody; the rest is flesh, in which the elbow's axis lies
BONE_M = 0.015
AXIS_SHARE, STRAIGHT_SHARE = 0.13, 0.2  # of the flesh: in the arm's plane; along the forearm, times cot(bend)
MAX_COTANGENT = 2.0
NECK_SIGMA_M = 0.0025  # where the palm begins, along the forearm
PLANE_SINE = 0.05


def elbow_covariance(joints: Joints, views: Limbs) -> Array:
    """The elbow's covariance (3, 3) in m²: the limbs' lines, and where in the flesh its axis lies.

    Flesh moves the axis in the plane in which the arm bends, the farther along the forearm the straighter the arm is.
    """
    flesh = _flesh(views, joints.elbow, joints.wrist, joints.upper_arm)
    result: Array = ELBOW_LINES * joints.covariance[:3, :3] + flesh
    return result


def wrist_covariance(joints: Joints) -> Array:
    """The wrist's covariance (3, 3) in m²: the limbs' lines, and where the palm begins."""
    forearm = unit(joints.wrist - joints.elbow)
    result: Array = WRIST_LINES * joints.covariance[3:, 3:] + NECK_SIGMA_M**2 * np.outer(forearm, forearm)
    return result


@compiled
def _flesh(views: Limbs, elbow: Array, wrist: Array, upper_arm: Array) -> Array:
    """What the flesh adds (3, 3); `upper_arm` (3,) is a unit vector from the elbow, zero where it is not known."""
    half_width = 0.0
    for k in range(len(views)):
        half_width += views[k].half_width / px_per_m(views[k], elbow) / len(views)
    forearm = unit(wrist - elbow)
    cosine = np.sum(forearm * upper_arm)
    hinge = np.cross(forearm, upper_arm)
    sine = np.sqrt(np.sum(hinge**2))
    plane = np.eye(3)
    if sine > PLANE_SINE:
        plane -= np.outer(hinge, hinge) / sine**2
    cotangent = min(abs(cosine) / max(sine, 1e-9), MAX_COTANGENT)
    shares = AXIS_SHARE**2 * plane + (STRAIGHT_SHARE * cotangent) ** 2 * np.outer(forearm, forearm)
    covariance: Array = max(half_width - BONE_M, 0.0) ** 2 * shares
    return covariance
