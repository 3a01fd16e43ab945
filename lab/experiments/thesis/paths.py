"""The motions of the thesis's sections 5.1 and 5.2: a joint swings alone, or the hand crosses the volume and turns."""

import math
from dataclasses import dataclass

import numpy as np

from common.geometry import Array, rotation_from_vector, vector_from_rotation
from local_site.simulation.config import BodyConfig, MotionConfig, Vector3
from local_site.simulation.motion import START_RISE, HandPath, minimum_jerk

FPS = 5.0  # the thesis's cameras gave about five pairs a second
STILL_S = 4.0  # the trackers learn the arm from it
LEAD_S = 2.0  # from where the arm was still to where the motion begins

ELBOW: Vector3 = (0.56, 0.40, 0.43)
ARM_AZIMUTH = math.radians(-15.0)  # the vertical plane of the arm, turned about the vertical through the elbow
STILL_RISE, LEAST_RISE, ELBOW_ARC = math.radians(60.0), math.radians(30.0), math.radians(90.0)
WRIST_REACH = math.radians(45.0)

CROSSING = np.array([[0.06, -0.03, -0.05], [-0.12, 0.03, 0.04]])  # from one side to the other, m from the start
TURN, TURN_PERIOD_S = math.radians(25.0), 4.0
PLANES = {"YZ": 0, "XZ": 1, "XY": 2}  # the axis about which a turn stays within the plane


@dataclass(frozen=True, slots=True)
class Recorded:
    """A film to record: the operator's motion, its path, and how many frames at its end are used."""

    motion: MotionConfig
    path: HandPath
    frames: int

    @property
    def seconds(self) -> float:
        """The length of the film, s, stillness and lead included."""
        return STILL_S + LEAD_S + (self.frames - 1) / FPS

    @property
    def filmed_frames(self) -> int:
        """The number of frames that are filmed, stillness and lead included."""
        return round(self.seconds * FPS) + 1


def elbow_arc(body: BodyConfig, frames: int) -> Recorded:
    """The forearm swings through 90 deg in a vertical plane at even speed; shoulder and elbow stand still.

    In that plane the elbow hangs below the line from shoulder to wrist at a swivel angle of 0, wherever the wrist is.
    """
    still = _wrist(body, STILL_RISE)

    def path(t_s: float) -> tuple[Array, Array]:
        rise = _swept(t_s, frames, STILL_RISE, LEAST_RISE, LEAST_RISE + ELBOW_ARC)
        upright = rotation_from_vector(np.array([0.0, rise - START_RISE, 0.0]))
        turned = rotation_from_vector(np.array([0.0, 0.0, ARM_AZIMUTH])) @ upright
        return _wrist(body, rise) - still, vector_from_rotation(turned)

    shoulder = np.array(ELBOW) - body.upper_arm_length * _level()
    motion = MotionConfig(still_s=STILL_S, shoulder=_vector(shoulder), wrist=_vector(still), swivel_deg=0.0)
    return Recorded(motion, HandPath(path), frames)


def wrist_arc(frames: int) -> Recorded:
    """The hand swings from -45 to 45 deg about the y axis, in the plane of the pictures; the arm stands still."""

    def path(t_s: float) -> tuple[Array, Array]:
        angle = _swept(t_s, frames, 0.0, -WRIST_REACH, WRIST_REACH)
        return np.zeros(3), np.array([0.0, angle, 0.0])

    return Recorded(MotionConfig(still_s=STILL_S), HandPath(path), frames)


def crossing(plane: str, frames: int) -> Recorded:
    """The wrist crosses the volume while the hand turns to and fro within a plane, one of PLANES."""
    axis = np.eye(3)[PLANES[plane]]

    def path(t_s: float) -> tuple[Array, Array]:
        moving_s = max(t_s - LEAD_S, 0.0)
        start = minimum_jerk(t_s / LEAD_S) * CROSSING[0]
        along = minimum_jerk(moving_s * FPS / (frames - 1)) * (CROSSING[1] - CROSSING[0])
        return start + along, TURN * math.sin(2.0 * math.pi * moving_s / TURN_PERIOD_S) * axis

    return Recorded(MotionConfig(still_s=STILL_S), HandPath(path), frames)


def _swept(t_s: float, frames: int, still: float, first: float, last: float) -> float:
    """An angle that leaves its place at rest for the first, and goes from there to the last evenly."""
    if t_s < LEAD_S:
        return still + minimum_jerk(t_s / LEAD_S) * (first - still)
    return first + (last - first) * min((t_s - LEAD_S) * FPS / (frames - 1), 1.0)


def _level() -> Array:
    """Ahead of the shoulder, level, in the plane of the arm (3,)."""
    return np.array([-math.cos(ARM_AZIMUTH), -math.sin(ARM_AZIMUTH), 0.0])


def _wrist(body: BodyConfig, rise: float) -> Array:
    """The wrist (3,) in m for a forearm that rises by an angle over the level."""
    along = math.cos(rise) * _level() + math.sin(rise) * np.array([0.0, 0.0, 1.0])
    return np.array(ELBOW) + body.forearm_length * along


def _vector(values: Array) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
