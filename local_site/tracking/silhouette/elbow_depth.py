"""Where in the limbs the elbow turns: nearer to the arm's back than the middle of the silhouette.

The bones lie right under the skin there, muscle on the other sides. Below the upper arm's skin the axis has a nearly
constant depth, however thick the arm; the forearm's muscles lie so that the offset from its middle stays small.
"""

import math
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.hand_model.descent import focal_length
from local_site.tracking.silhouette.joint_equations import Shifts
from local_site.tracking.silhouette.medial import Line

FOREARM_OFFSET_SHARE = 0.13
UPPER_ARM_DEPTH_M = 0.036
CLEAR_BEND_SINE = 0.35
MIN_LENGTH_M = 1e-6


@dataclass(frozen=True, slots=True)
class Bend:
    """The bent arm: elbow (3,) and wrist (3,) in m, unit vector (3,) from the elbow up the upper arm."""

    elbow: Array
    wrist: Array
    upper_arm: Array

    @property
    def forearm(self) -> Array:
        """Unit vector (3,) from the elbow to the wrist."""
        arm = self.wrist - self.elbow
        unit: Array = arm / max(math.sqrt(float(arm @ arm)), MIN_LENGTH_M)
        return unit

    @property
    def cosine(self) -> float:
        """Of the angle between the limbs, -1 where the arm is straight."""
        return max(-1.0, min(1.0, float(self.forearm @ self.upper_arm)))

    def behind(self, limb: Array, other: Array) -> Array:
        """Towards the arm's back across a limb (3,), in the plane of both; shorter where the arm is nearly straight."""
        sine = math.sqrt(max(1 - self.cosine**2, 0.0))
        away: Array = self.cosine * limb - other
        return away / max(sine, 1e-9) * min(1.0, sine / CLEAR_BEND_SINE)


def shifts_of(projection: Array, view: Features, bend: Bend) -> Shifts:
    """From the medial lines of a view to the elbow's axis."""
    offset = FOREARM_OFFSET_SHARE * 0.5 * view.root_width
    across = offset * bend.behind(bend.forearm, bend.upper_arm)
    first = _shown(projection, bend.elbow, view.root, across) / (1 - view.root_share)
    if view.upper_arm is None:
        return Shifts(first)
    offset = 0.5 * view.upper_arm_width - UPPER_ARM_DEPTH_M * _px_per_m(projection, bend.elbow)
    across = offset * bend.behind(bend.upper_arm, bend.forearm)
    return Shifts(first, _shown(projection, bend.elbow, view.upper_arm, across))


def _px_per_m(projection: Array, point: Array) -> float:
    return focal_length(projection) / float(projection[2, :3] @ point + projection[2, 3])


def _shown(projection: Array, elbow: Array, line: Line, offset_px: Array) -> float:
    """How far along a line's normal an offset (3,), in px at the elbow's distance, shows in the view."""
    x, y, distance = (projection[:, :3] @ elbow + projection[:, 3]).tolist()
    pixel = np.array([x / distance, y / distance])
    motion = (projection[:2, :3] - pixel[:, None] * projection[2, :3]) @ offset_px / distance
    return float(line.normal @ motion) / _px_per_m(projection, elbow)
