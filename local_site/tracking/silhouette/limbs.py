"""The limbs as views show them, as records for the compiled equations, and where in them the elbow's axis lies.

The elbow's axis is at a nearly constant depth beneath the skin of the arm's back: there the bones lie right under the
skin, and muscle on the other sides, so that the middle of the silhouette depends on the build of the arm.
"""

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import focal_length, image_of
from local_site.kernels.compiled import compiled
from local_site.tracking.features.features import Features

FOREARM_DEPTH_M, UPPER_ARM_DEPTH_M = 0.0285, 0.037
CLEAR_BEND_SINE = 0.35
MIN_LENGTH_M = 1e-6
LINES = ("forearm", "root", "forearm_sides", "upper_arm", "upper_arm_sides")
NUMBERS = ("focal_px", "has_upper_arm", "has_wrist", "half_width")
SHOULDER_END, ELBOW, WRIST = range(3)  # rows of `guess`
LIMBS = np.dtype(
    [
        ("projection", np.float64, (3, 4)),
        *((name, np.float64, (2, 2)) for name in LINES),
        ("guess", np.float64, (4, 2)),
        *((name, np.float64) for name in NUMBERS),
    ]
)

Limbs = NDArray[np.void]
"""Records of `LIMBS` (V,), one for each view."""


class SilhouetteLimb(Protocol):
    """One of the records.

    Lines (2, 2) are a point and a direction; the upper arm is one only if `has_upper_arm` is not 0. Sides (2, 2) and
    `guess` (4, 2), the rough joints, are points. All in px.
    """

    projection: Array
    forearm: Array
    root: Array
    forearm_sides: Array
    upper_arm: Array
    upper_arm_sides: Array
    guess: Array
    focal_px: float
    has_upper_arm: float
    has_wrist: float
    half_width: float


def limbs_of(projections: Sequence[Array], features: Sequence[Features]) -> Limbs:
    """The limbs of every view (V,), by its projection (3, 4)."""
    records = np.zeros(len(features), LIMBS)
    for k, (m, view) in enumerate(zip(projections, features, strict=True)):
        upper = view.forearm if view.upper_arm is None else view.upper_arm
        lines = view.forearm.pair, view.root.pair, view.forearm_sides, upper.pair, view.upper_arm_sides
        numbers = focal_length(m), view.upper_arm is not None, view.wrist is not None, view.half_width
        records[k] = (m, *lines, view.guess.points, *numbers)
    return records


@compiled
def unit(vector: Array) -> Array:
    """A vector (3,) at length one."""
    return vector / max(math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2), MIN_LENGTH_M)


@compiled
def behind(limb: Array, other: Array) -> Array:
    """The direction (3,) to the arm's back across a limb, in the plane of both; shorter if the arm is nearly straight.

    Both are unit vectors (3,) from the elbow.
    """
    cosine = max(-1.0, min(1.0, limb[0] * other[0] + limb[1] * other[1] + limb[2] * other[2]))
    sine = math.sqrt(max(1 - cosine**2, 0.0))
    away: Array = (cosine * limb - other) / max(sine, 1e-9) * min(1.0, sine / CLEAR_BEND_SINE)
    return away


@compiled
def elbow_shifts(view: SilhouetteLimb, elbow: Array, forearm: Array, upper_arm: Array) -> tuple[float, float]:
    """The offsets in px of the elbow's axis from a view's root and upper arm line, along their normals.

    The elbow (3,) in m; unit vectors (3,) from it along the limbs.
    """
    first = _shift(view, elbow, view.root, view.forearm_sides, FOREARM_DEPTH_M, behind(forearm, upper_arm))
    if not view.has_upper_arm:
        return first, 0.0
    towards_back = behind(upper_arm, forearm)
    return first, _shift(view, elbow, view.upper_arm, view.upper_arm_sides, UPPER_ARM_DEPTH_M, towards_back)


@compiled
def _shift(view: SilhouetteLimb, elbow: Array, line: Array, sides: Array, depth_m: float, towards_back: Array) -> float:
    """The offset in px from a limb's line of the axis at a depth beneath the skin of its back.

    The limb is assumed to be round: the offset shrinks as the view turns from beside to behind. 0 where that skin is
    not seen.
    """
    motion, scale = image_motion(view.projection, elbow, towards_back), px_per_m(view, elbow)
    shown = (line[1, 0] * motion[1] - line[1, 1] * motion[0]) / scale
    skin = sides[1] if shown > 0 else sides[0]
    half = abs(line[1, 0] * (skin[1] - line[0, 1]) - line[1, 1] * (skin[0] - line[0, 0]))
    return 0.0 if math.isnan(half) else shown * (half - depth_m * scale)


@compiled
def px_per_m(view: SilhouetteLimb, point: Array) -> float:
    """The scale of the view in px per m at a point (3,)."""
    m = view.projection
    return float(view.focal_px / (m[2, 0] * point[0] + m[2, 1] * point[1] + m[2, 2] * point[2] + m[2, 3]))


@compiled
def image_motion(projection: Array, point: Array, direction: Array) -> Array:
    """Pixels per m (2,) by which the image of a point (3,) moves along a direction (3,)."""
    pixel, _, depth = image_of(projection, point)
    g = np.zeros(3)
    for d in range(3):
        g += projection[:, d] * direction[d]
    motion: Array = (g[:2] - pixel * g[2]) / depth
    return motion
