"""Whether the hand is open, its fingers stretched and apart (thesis 4.2), by its points in space; pure."""

import numpy as np

from common.geometry import Array
from local_site.tracking.eye.arm_points import FINGERS

STRETCHED, STILL_STRETCHED = 0.965, 0.93  # of a finger's own length, from knuckle to tip, of the finger bent most
APART, STILL_APART = 1.25, 1.15  # tips' distances over the knuckles', of the mean of neighbours


class HandPosture:
    """Tells an open hand, with hysteresis."""

    def __init__(self) -> None:
        self._open = self._apart = False

    def update(self, points: Array) -> tuple[bool, bool]:
        """Tell of points (22, 3) in m whether the fingers are stretched, and whether they lie together."""
        fingers = np.array([points[knuckle : knuckle + 4] for knuckle in FINGERS])  # (4, 4, 3)
        along = np.linalg.norm(fingers[:, 3] - fingers[:, 0], axis=1)
        length = np.linalg.norm(np.diff(fingers, axis=1), axis=2).sum(axis=1)
        self._open = float((along / length).min()) > (STILL_STRETCHED if self._open else STRETCHED)
        knuckles = np.linalg.norm(np.diff(fingers[:, 0], axis=0), axis=1)
        tips = np.linalg.norm(np.diff(fingers[:, 3], axis=0), axis=1)
        self._apart = float(np.mean(tips / knuckles)) > (STILL_APART if self._apart else APART)
        return self._open, not self._apart
