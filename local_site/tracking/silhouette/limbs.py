"""The limbs as views show them, as plain records for the compiled equations."""

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import focal_length
from local_site.kernels.compiled import compiled
from local_site.tracking.features.features import Features

# lines are a point and a direction; the upper arm is one only where `has_upper_arm` is not 0
LIMBS = np.dtype(
    [
        ("projection", np.float64, (3, 4)),
        ("focal_px", np.float64),
        ("forearm", np.float64, (2, 2)),
        ("root", np.float64, (2, 2)),
        ("forearm_sides", np.float64, (2, 2)),
        ("upper_arm", np.float64, (2, 2)),
        ("upper_arm_sides", np.float64, (2, 2)),
        ("has_upper_arm", np.int64),
        ("has_wrist", np.int64),
        ("half_width", np.float64),
        ("elbow", np.float64, (2,)),
        ("wrist", np.float64, (2,)),
        ("shoulder_end", np.float64, (2,)),
    ]
)

Limbs = NDArray[np.void]
"""Records of `LIMBS` (V,), one for each view."""


class SilhouetteLimb(Protocol):
    """One of the records."""

    projection: Array
    focal_px: float
    forearm: Array
    root: Array
    forearm_sides: Array
    upper_arm: Array
    upper_arm_sides: Array
    has_upper_arm: int
    has_wrist: int
    half_width: float
    elbow: Array
    wrist: Array
    shoulder_end: Array


def limbs_of(projections: Sequence[Array], features: Sequence[Features]) -> Limbs:
    """The limbs of every view (V,); places are the rough ones, in px."""
    records = np.zeros(len(features), LIMBS)
    for k, (projection, view) in enumerate(zip(projections, features, strict=True)):
        upper = view.upper_arm
        line = (view.forearm if upper is None else upper).pair
        records[k] = (
            projection,
            focal_length(projection),
            view.forearm.pair,
            view.root.pair,
            view.forearm_sides,
            line,
            view.upper_arm_sides,
            upper is not None,
            view.wrist is not None,
            view.half_width,
            view.guess.elbow,
            view.guess.wrist,
            view.guess.shoulder_end,
        )
    return records


FOREARM_DEPTH_M, UPPER_ARM_DEPTH_M = 0.0285, 0.037
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
def elbow_shifts(view: SilhouetteLimb, elbow: Array, forearm: Array, upper_arm: Array) -> tuple[float, float]:
    """How far beside the root and the upper arm's line of a view, along their normals in px, the elbow's axis lies.

    The elbow (3,) in m; unit vectors (3,) from it along the limbs.
    """
    first = _shift(view, elbow, view.root, view.forearm_sides, FOREARM_DEPTH_M, behind(forearm, upper_arm))
    if not view.has_upper_arm:
        return first, 0.0
    towards_back = behind(upper_arm, forearm)
    return first, _shift(view, elbow, view.upper_arm, view.upper_arm_sides, UPPER_ARM_DEPTH_M, towards_back)


@compiled
def _shift(view: SilhouetteLimb, elbow: Array, line: Array, sides: Array, depth_m: float, towards_back: Array) -> float:
    """How far beside a limb's line, px, the axis lies that is so deep beneath the skin of its back.

    The limb counts as round: the less a view shows the back from the side, the less of it. Nothing where that skin is
    not seen.
    """
    shown = _shown(view, elbow, line, towards_back)
    skin = sides[1] if shown > 0 else sides[0]
    half = abs(line[1, 0] * (skin[1] - line[0, 1]) - line[1, 1] * (skin[0] - line[0, 0]))
    return 0.0 if math.isnan(half) else shown * (half - depth_m * px_per_m(view, elbow))


@compiled
def px_per_m(view: SilhouetteLimb, point: Array) -> float:
    """How large, in px, the view shows a metre at a point (3,)."""
    m = view.projection
    return float(view.focal_px / (m[2, 0] * point[0] + m[2, 1] * point[1] + m[2, 2] * point[2] + m[2, 3]))


@compiled
def _shown(view: SilhouetteLimb, elbow: Array, line: Array, offset: Array) -> float:
    """How far along a line's normal an offset (3,) shows in the view, in lengths of the elbow's distance."""
    motion = image_motion(view.projection, elbow, offset)
    return float((line[1, 0] * motion[1] - line[1, 1] * motion[0]) / px_per_m(view, elbow))


@compiled
def image_motion(projection: Array, point: Array, direction: Array) -> Array:
    """Pixels per m (2,) by which the image of a point (3,) moves along a direction (3,)."""
    h, g = projection[:, 3].copy(), np.zeros(3)
    for d in range(3):
        h += projection[:, d] * point[d]
        g += projection[:, d] * direction[d]
    motion: Array = (g[:2] - h[:2] / h[2] * g[2]) / h[2]
    return motion
