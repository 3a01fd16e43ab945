"""Motions of the simulated operator by name: the arm's pose by time, and when the hand opens."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from common.errors import ConfigError
from common.geometry import Array, rotation_from_vector, vector_from_rotation
from local_site.simulation.body import BodyPose
from local_site.simulation.config import BodyConfig, MotionConfig, MotionName

CHECKED_S = 20.0
LEAST_SINE = 1e-3
TREMOR_HZ = (7.3, 9.1, 10.7)
OPENING_ROLL = math.radians(45.0)
# Hand axes (columns x distal, y radial, z dorsal) at the start: up to the operator's right, the thumb in front.
START_RISE = math.radians(35.0)
START_HAND = np.array(
    [
        [-math.cos(START_RISE), 0.0, math.sin(START_RISE)],
        [0.0, -1.0, 0.0],
        [math.sin(START_RISE), 0.0, math.cos(START_RISE)],
    ]
)
START_ROLL = math.radians(10.0)
RAMP_S = 2.0
OPENING_S = 0.2
OPEN_S = 0.5


class Path(Protocol):
    """The path of the hand, as a function of the time since it began to move, s."""

    def at(self, t_s: float) -> tuple[Array, Array, float]: ...

    def openings_until(self, t_s: float) -> int: ...


@dataclass(frozen=True, slots=True)
class HandPath:
    """A motion: the wrist's offset and the hand's turn by time in the period, and when the hand begins to open (s)."""

    path: Callable[[float], tuple[Array, Array]]
    period_s: float = math.inf
    openings_s: tuple[float, ...] = ()

    def at(self, t_s: float) -> tuple[Array, Array, float]:
        """At a time from 0 on: the wrist's offset (3,) in m, the hand's turn (3,) as a rotation vector in rad, and its
        openness, 0 to 1."""
        phase = math.fmod(t_s, self.period_s)
        openness = max((_opening(phase - start) for start in self.openings_s), default=0.0)
        return *self.path(phase), openness

    def openings_until(self, t_s: float) -> int:
        """Count the openings that have begun."""
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
# at 5 s and too low until 10 s, then corrected in position and direction; the gripper closes; until 24 s up and over to
# the target; until 32 s corrected there; the gripper opens. Then back to the start. All of it above the block of the
# cell as it is configured by default, which this operator does not see.
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
    (34.0, -0.15, -0.05, -0.065, 0.0, 5.0),
    (37.0, 0.0, 0.0, 0.0, 0.0, 0.0),
)
_GRASP_AND_RELEASE_S = (16.4, 32.4)


def _along(waypoints: Sequence[tuple[float, ...]]) -> Callable[[float], tuple[Array, Array]]:
    changes_s = [t_s for t_s, *_ in waypoints[1:-1]]

    def path(t_s: float) -> tuple[Array, Array]:
        k = bisect_right(changes_s, t_s)
        (start_s, *a), (end_s, *b) = waypoints[k], waypoints[k + 1]
        share = minimum_jerk((t_s - start_s) / (end_s - start_s))
        *offset, yaw_deg, pitch_deg = (start + share * (end - start) for start, end in zip(a, b, strict=True))
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
    "reach_and_adjust": HandPath(_along(_REACH_AND_ADJUST), _REACH_AND_ADJUST[-1][0], _GRASP_AND_RELEASE_S),
    "toggles": HandPath(_still, 2.0, (0.5,)),
}


class Motion:
    """One operator's motion, a pure function of the time since its start.

    Along `path` where one is given, else along that of the configuration's name: ConfigError when it is out of reach.
    """

    def __init__(self, config: MotionConfig, body: BodyConfig, seed: int, path: Path | None = None) -> None:
        self._config = config
        self._upper_arm, self._forearm = body.upper_arm_length, body.forearm_length
        self._path = path or PATHS[config.name]
        self._roll = START_ROLL + math.radians(config.roll_deg)
        self._shoulder = np.array(config.shoulder)
        self._start = np.array(config.wrist)
        self._phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (len(TREMOR_HZ), 3))
        for t_s in np.arange(0.0, CHECKED_S, 0.2) if path is None else ():
            self.pose(config.still_s + t_s)

    def pose(self, t_s: float) -> BodyPose:
        """The pose at a time; ConfigError when the arm cannot reach so far from its shoulder."""
        offset, turn, openness = self._path.at(max(t_s - self._config.still_s, 0.0))
        wrist = self._start + offset + self._tremor(t_s)
        roll = rotation_from_vector(np.array([self._roll + OPENING_ROLL * openness, 0.0, 0.0]))
        return BodyPose(
            shoulder=self._shoulder,
            elbow=self._elbow(wrist),
            wrist=wrist,
            operator_R_hand=rotation_from_vector(turn) @ START_HAND @ roll,
            openness=openness,
        )

    def openings_until(self, t_s: float) -> int:
        """Count how often the hand has begun to open."""
        return self._path.openings_until(t_s - self._config.still_s)

    def _elbow(self, wrist: Array) -> Array:
        """The elbow on its circle about the line from shoulder to wrist, turned by the swivel angle from hanging."""
        reach = wrist - self._shoulder
        distance = math.sqrt(float(reach @ reach))
        a, b = self._upper_arm, self._forearm
        along = (a * a - b * b + distance * distance) / (2.0 * distance)
        if a * a <= along * along:
            raise ConfigError(f"the simulated arm cannot reach {distance:.3f} m; move shoulder or wrist closer")
        axis = reach / distance
        x, y, z = axis.tolist()
        sine = math.hypot(x, y)
        if sine < LEAST_SINE:
            raise ConfigError("the wrist is straight above or below the shoulder; move one of them aside")
        swivel = math.radians(self._config.swivel_deg)
        hanging, aside = np.array([[x * z / sine, y * z / sine, -sine], [-y / sine, x / sine, 0.0]])
        out = math.cos(swivel) * hanging + math.sin(swivel) * aside
        elbow: Array = self._shoulder + along * axis + math.sqrt(a * a - along * along) * out
        return elbow

    def _tremor(self, t_s: float) -> Array:
        if not self._config.tremor_mm:
            return np.zeros(3)
        turns = 2.0 * np.pi * np.array(TREMOR_HZ)[:, None] * t_s + self._phases
        tremor: Array = self._config.tremor_mm * 1e-3 * np.mean(np.sin(turns), axis=0)
        return tremor
