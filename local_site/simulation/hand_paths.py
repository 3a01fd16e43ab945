"""The motions by name: displacement, turn and opening of the hand since the end of the initial stillness."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array, rotation_from_vector, vector_from_rotation
from local_site.simulation.config import MotionName

RAMP_S = 2.0
OPENING_S = 0.2
OPEN_S = 0.5


@dataclass(frozen=True, slots=True)
class HandState:
    """Displacement of the wrist (3,) in m and turn of the hand (3,) as a rotation vector in rad; openness 0 to 1."""

    offset: Array
    turn: Array
    openness: float


@dataclass(frozen=True, slots=True)
class HandPath:
    """A motion: the wrist's offset and the hand's turn by time in the period, and when the hand begins to open (s)."""

    path: Callable[[float], tuple[Array, Array]]
    period_s: float = math.inf
    openings_s: tuple[float, ...] = ()

    def at(self, t_s: float) -> HandState:
        """The state at a time from 0 on."""
        phase = math.fmod(t_s, self.period_s)
        offset, turn = self.path(phase)
        return HandState(offset, turn, max((_opening(phase - start) for start in self.openings_s), default=0.0))

    def openings_until(self, t_s: float) -> int:
        """How many openings have begun."""
        if t_s < 0 or not self.openings_s:
            return 0
        periods, phase = divmod(t_s, self.period_s)
        return int(periods) * len(self.openings_s) + sum(phase >= start for start in self.openings_s)


def minimum_jerk(fraction: float) -> float:
    """From 0 to 1 with velocity and acceleration zero at both ends (Flash and Hogan 1985)."""
    s = min(max(fraction, 0.0), 1.0)
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


def _opening(since_s: float) -> float:
    rise = minimum_jerk(since_s / OPENING_S)
    return rise - minimum_jerk((since_s - OPENING_S - OPEN_S) / OPENING_S)


def _still(_t_s: float) -> tuple[Array, Array]:
    return np.zeros(3), np.zeros(3)


def _figure_of_eight(t_s: float) -> tuple[Array, Array]:
    swell, phase = minimum_jerk(t_s / RAMP_S), 2.0 * math.pi * t_s / 6.0
    offset = np.array([-0.07 * (1.0 - math.cos(phase)), 0.0, 0.05 * math.sin(2.0 * phase)])
    return swell * offset, np.zeros(3)


def _rotation(axis: int) -> Callable[[float], tuple[Array, Array]]:
    direction = np.eye(3)[axis]

    def path(t_s: float) -> tuple[Array, Array]:
        angle = minimum_jerk(t_s / RAMP_S) * math.radians(25.0) * math.sin(2.0 * math.pi * t_s / 5.0)
        return np.zeros(3), angle * direction

    return path


# Waypoints: time in the period in s; the wrist's offset x, y, z in m; the hand's turn about the vertical z and about y
# in degrees. Forward is -y, the operator's right -x.

# Down before forward, so that a tool a little off pushes the block aside instead of pressing on it from above; release
# 3 cm above the table, since this operator does not see the block. The hand opens while the wrist rests between two
# equal waypoints. What was carried over is carried back, so that it is no obstacle later.
_PICK_AND_PLACE = (
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (0.8, 0.0, 0.0, 0.0, 0.0, 0.0),
    (2.5, 0.0, 0.0, -0.16, 0.0, 0.0),
    (3.6, 0.0, -0.08, -0.16, 0.0, 0.0),
    (5.0, 0.0, -0.08, -0.16, 0.0, 0.0),
    (6.0, 0.0, -0.08, -0.12, -10.0, 0.0),
    (7.8, -0.20, -0.08, -0.12, 10.0, 0.0),
    (8.6, -0.20, -0.08, -0.13, 0.0, 0.0),
    (10.0, -0.20, -0.08, -0.13, 0.0, 0.0),
    (11.1, -0.20, -0.02, -0.13, 0.0, 0.0),
    (13.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (13.8, 0.0, 0.0, 0.0, 0.0, 0.0),
    (15.7, -0.20, 0.0, -0.16, 0.0, 0.0),
    (16.8, -0.20, -0.08, -0.16, 0.0, 0.0),
    (18.2, -0.20, -0.08, -0.16, 0.0, 0.0),
    (19.2, -0.20, -0.08, -0.12, 10.0, 0.0),
    (21.0, 0.0, -0.08, -0.12, -10.0, 0.0),
    (21.8, 0.0, -0.08, -0.13, 0.0, 0.0),
    (23.2, 0.0, -0.08, -0.13, 0.0, 0.0),
    (24.3, 0.0, -0.02, -0.13, 0.0, 0.0),
    (26.0, 0.0, 0.0, 0.0, 0.0, 0.0),
)
_OPENINGS_S = (3.9, 8.9, 17.1, 22.1)

# As in the thesis's figures 6.15 and 6.16, 5 frames to a second: until 16 s down and ahead to the object, too far ahead
# at 5 s and too low until 10 s, then corrected in position and direction; until 24 s up and over to the target; until
# 32 s corrected there. Then back to the start. All of it above the block, which this operator does not see.
_REACH_AND_ADJUST = (
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (4.5, 0.0, -0.09, -0.06, 6.0, -4.0),
    (7.0, 0.005, -0.07, -0.075, 9.0, -2.0),
    (10.0, 0.0, -0.085, -0.08, 14.0, 5.0),
    (13.0, -0.01, -0.075, -0.07, 5.0, 10.0),
    (16.0, 0.0, -0.08, -0.07, -4.0, 6.0),
    (18.0, 0.0, -0.08, -0.07, -4.0, 6.0),
    (20.0, -0.02, -0.07, -0.03, -7.0, 2.0),
    (24.0, -0.15, -0.03, -0.04, -12.0, -4.0),
    (27.0, -0.14, -0.045, -0.06, -4.0, 4.0),
    (29.5, -0.155, -0.05, -0.065, 3.0, 8.0),
    (32.0, -0.15, -0.05, -0.065, 0.0, 5.0),
    (35.0, 0.0, 0.0, 0.0, 0.0, 0.0),
)


def _along(waypoints: Sequence[tuple[float, ...]]) -> Callable[[float], tuple[Array, Array]]:
    table = np.array(waypoints)

    def path(t_s: float) -> tuple[Array, Array]:
        k = int(np.sum(table[1:-1, 0] <= t_s))
        a, b = table[k], table[k + 1]
        *offset, yaw_deg, pitch_deg = a[1:] + minimum_jerk((t_s - a[0]) / (b[0] - a[0])) * (b[1:] - a[1:])
        return np.array(offset), _turn(yaw_deg, pitch_deg)

    return path


def _turn(yaw_deg: float, pitch_deg: float) -> Array:
    """About y, then about z, as one rotation vector (3,) in rad."""
    yaw = np.array([0.0, 0.0, math.radians(yaw_deg)])
    if not pitch_deg:
        return yaw
    pitch = np.array([0.0, math.radians(pitch_deg), 0.0])
    return vector_from_rotation(rotation_from_vector(yaw) @ rotation_from_vector(pitch))


PATHS: dict[MotionName, HandPath] = {
    "hold": HandPath(_still),
    "figure_of_eight": HandPath(_figure_of_eight),
    "rotate_x": HandPath(_rotation(0)),
    "rotate_y": HandPath(_rotation(1)),
    "rotate_z": HandPath(_rotation(2)),
    "pick_and_place": HandPath(_along(_PICK_AND_PLACE), _PICK_AND_PLACE[-1][0], _OPENINGS_S),
    "reach_and_adjust": HandPath(_along(_REACH_AND_ADJUST), _REACH_AND_ADJUST[-1][0]),
    "toggles": HandPath(_still, 2.0, (0.5,)),
}
