"""Handling of a flask, frame by frame: the arm reaches, grasps, carries, sets down, in the camera's frame."""

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array, rotation_from_vector
from local_site.simulation.hazel import FOREARM_M, PALM_POINT_M, TrueArm, reaching_arm
from local_site.simulation.textured_arm import LimbPose

HANDLING_FRAMES = 200
SHOULDER = np.array([-0.26, -0.19, 1.36])
LEAN = 0.12  # of the palm's motion, with which the shoulder follows it
TABLE_Y = 0.21  # the table's height in the camera's frame, whose y points down, m
FLASK_RADIUS_M, FLASK_HALF_M = 0.030, 0.080
FLASK_IN_PALM = np.array([0.0, 0.0, 0.045])  # on the palm's side of the hand, which the camera does not see
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # its z up the columns of the picture
GRASPING_Y = TABLE_Y - FLASK_HALF_M


@dataclass(frozen=True, slots=True)
class PalmStop:
    """The pose of a resting palm: its position (3,) in m, and how far the forearm is turned about its axis, rad."""

    palm: tuple[float, float, float]
    roll: float = 0.0


@dataclass(frozen=True, slots=True)
class Handling:
    """The palm's stops by frame, in their order, and the frames between which it holds the flask.

    Between two stops the palm moves along a line with minimum jerk.
    """

    stops: Mapping[int, PalmStop]
    grasped: int
    released: int

    def arm(self, frame: float) -> TrueArm:
        """The arm at a frame; at frame 0 both links are parallel to the picture."""
        palm, roll = self._palm_and_roll(frame)
        shoulder = SHOULDER + LEAN * (palm - self._palm_and_roll(0.0)[0])
        arm = reaching_arm(shoulder, palm, FOREARM_M + PALM_POINT_M)
        return replace(arm, forearm=arm.forearm @ rotation_from_vector(np.array([0.0, 0.0, roll])))

    def flask(self, frame: float) -> LimbPose:
        """The pose of the flask, which stays upright in the hand."""
        palm, _ = self._palm_and_roll(min(max(frame, self.grasped), self.released))
        return LimbPose(palm + FLASK_IN_PALM, UPRIGHT)

    def limb_poses(self, frame: float) -> tuple[LimbPose, ...]:
        """The poses of upper arm, forearm and flask, for rendering."""
        return (*self.arm(frame).limb_poses(), self.flask(frame))

    def _palm_and_roll(self, frame: float) -> tuple[Array, float]:
        frames = list(self.stops)
        before = min(max(bisect_right(frames, frame) - 1, 0), len(frames) - 2)
        first, last = frames[before], frames[before + 1]
        s = min(max((frame - first) / (last - first), 0.0), 1.0)
        done = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        a, b = self.stops[first], self.stops[last]
        palm: Array = (1.0 - done) * np.array(a.palm) + done * np.array(b.palm)
        return palm, (1.0 - done) * a.roll + done * b.roll


GRASPING = Handling(
    stops={
        0: PalmStop((0.10, 0.00, 1.36)),
        10: PalmStop((0.10, 0.00, 1.36)),
        60: PalmStop((0.18, GRASPING_Y, 1.41), 0.25),
        75: PalmStop((0.18, GRASPING_Y, 1.41), 0.25),
        116: PalmStop((0.15, -0.05, 1.37), 0.1),
        160: PalmStop((0.10, 0.02, 1.46), 0.1),
        185: PalmStop((0.15, 0.00, 1.42)),
        199: PalmStop((0.15, 0.00, 1.42)),
    },
    grasped=70,
    released=199,
)
MOVING = Handling(
    stops={
        0: PalmStop((0.08, 0.00, 1.36)),
        8: PalmStop((0.08, 0.00, 1.36)),
        45: PalmStop((0.14, GRASPING_Y, 1.32), 0.2),
        58: PalmStop((0.14, GRASPING_Y, 1.32), 0.2),
        90: PalmStop((0.12, 0.00, 1.36), 0.1),
        112: PalmStop((0.14, 0.00, 1.45), 0.1),
        140: PalmStop((0.16, GRASPING_Y, 1.47), 0.2),
        154: PalmStop((0.16, GRASPING_Y, 1.47), 0.2),
        184: PalmStop((0.10, 0.02, 1.40)),
        199: PalmStop((0.10, 0.02, 1.40)),
    },
    grasped=54,
    released=148,
)
