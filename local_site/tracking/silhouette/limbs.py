"""The limbs as views show them, as plain records for the compiled equations."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import focal_length
from local_site.tracking.silhouette.features import Features

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
