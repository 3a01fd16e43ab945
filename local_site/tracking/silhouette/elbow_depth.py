"""Where in the limbs the elbow turns: nearer to the arm's back than the middle of the silhouette.

The bones lie right under the skin there, muscle on the other sides. Below the upper arm's skin the axis has a nearly
constant depth, however thick the arm; the forearm's muscles lie so that the offset from its middle stays small.
"""

import math

import numpy as np

from common.geometry import Array
from local_site.compiled import compiled
from local_site.tracking.silhouette.limbs import Limb

FOREARM_OFFSET_SHARE = 0.13
UPPER_ARM_DEPTH_M = 0.036
CLEAR_BEND_SINE = 0.35
MIN_LENGTH_M = 1e-6


@compiled
def unit(vector: Array) -> Array:
    """A vector (3,) at length one."""
    return vector / max(math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2), MIN_LENGTH_M)


@compiled
def behind(limb: Array, other: Array) -> Array:
    """Towards the arm's back across a limb, in the plane of both; shorter where the arm is nearly straight.

    Both are unit vectors (3,) from the elbow.
    """
    cosine = max(-1.0, min(1.0, limb[0] * other[0] + limb[1] * other[1] + limb[2] * other[2]))
    sine = math.sqrt(max(1 - cosine**2, 0.0))
    away: Array = (cosine * limb - other) / max(sine, 1e-9) * min(1.0, sine / CLEAR_BEND_SINE)
    return away


@compiled
def elbow_shifts(view: Limb, elbow: Array, forearm: Array, upper_arm: Array) -> tuple[float, float]:
    """How far beside the root and the upper arm's line of a view, along their normals in px, the elbow's axis lies.

    The elbow (3,) in m; unit vectors (3,) from it along the limbs.
    """
    offset = FOREARM_OFFSET_SHARE * 0.5 * view.root_width
    first = _shown(view, elbow, view.root, offset * behind(forearm, upper_arm)) / (1 - view.root_share)
    if not view.has_upper_arm:
        return first, 0.0
    offset = 0.5 * view.upper_arm_width - UPPER_ARM_DEPTH_M * _px_per_m(view, elbow)
    return first, _shown(view, elbow, view.upper_arm, offset * behind(upper_arm, forearm))


@compiled
def _px_per_m(view: Limb, point: Array) -> float:
    m = view.projection
    return float(view.focal_px / (m[2, 0] * point[0] + m[2, 1] * point[1] + m[2, 2] * point[2] + m[2, 3]))


@compiled
def _shown(view: Limb, elbow: Array, line: Array, offset_px: Array) -> float:
    """How far along a line's normal an offset (3,), in px at the elbow's distance, shows in the view."""
    motion = image_motion(view.projection, elbow, offset_px)
    return float((line[1, 0] * motion[1] - line[1, 1] * motion[0]) / _px_per_m(view, elbow))


@compiled
def image_motion(projection: Array, point: Array, direction: Array) -> Array:
    """Pixels per m (2,) by which the image of a point (3,) moves along a direction (3,)."""
    h, g = projection[:, 3].copy(), np.zeros(3)
    for d in range(3):
        h += projection[:, d] * point[d]
        g += projection[:, d] * direction[d]
    motion: Array = (g[:2] - h[:2] / h[2] * g[2]) / h[2]
    return motion
