"""Motions of the filmed arm: the poses of shoulder, elbow and hand by time, for an arm of given lengths."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from common.errors import ConfigError
from common.geometry import Array, rotation_from_vector
from local_site.simulation.body import BodyPose
from local_site.simulation.motion import minimum_jerk

FilmMotion = Literal["carry", "turn", "elbow_swing", "hold", "toggle"]

WRIST = np.array([0.53, 0.45, 0.60])
REACH_M = 0.52  # the arm for which the paths are given; others are scaled
SHOULDER_FROM_WRIST = np.array([0.34, -0.10, -0.16])
TREMOR_HZ = (7.3, 9.1, 10.7)
TREMOR_M = 6e-4
OPENING_S, OPEN_S = 0.2, 0.6
RISE = math.radians(25.0)
# The hand's axes (columns x distal, y radial, z dorsal) at the start: to the left in the picture, the thumb in front.
PALM_DOWN = np.array([[-math.cos(RISE), 0.0, math.sin(RISE)], [0.0, -1.0, 0.0], [math.sin(RISE), 0.0, math.cos(RISE)]])
# s; the wrist's offset x, y, z in m; the hand's turn about the vertical in degrees.
_CARRY = (
    (0.0, 0.0, 0.0, 0.0, 0.0),
    (0.4, 0.0, 0.0, 0.0, 0.0),
    (1.4, 0.02, -0.02, -0.14, 0.0),
    (1.9, 0.0, -0.06, -0.14, 8.0),
    (2.6, -0.04, -0.06, -0.05, 0.0),
    (3.8, -0.14, 0.02, -0.06, -12.0),
    (4.5, -0.13, 0.03, -0.13, 0.0),
    (5.0, -0.12, 0.0, -0.13, 0.0),
    (6.5, 0.0, 0.0, 0.0, 0.0),
    (7.0, 0.0, 0.0, 0.0, 0.0),
)
_CARRY_OPENINGS_S = (1.95, 4.55)
_TOGGLE_OPENINGS_S = (0.6, 2.0, 3.4)
_TOGGLE_PERIOD_S = 4.2


@dataclass(frozen=True, slots=True)
class ArmMotion:
    """One arm's motion: its lengths in m, what it does, how the hand is rolled (rad, 0 is palm down), its seed."""

    name: FilmMotion
    upper_arm_m: float
    forearm_m: float
    roll: float
    seed: int

    def pose(self, t_s: float) -> BodyPose:
        """The pose at a time from the motion's start; ConfigError when the wrist is out of reach."""
        scale = (self.upper_arm_m + self.forearm_m) / REACH_M
        offset, turn, openness, swivel = _PATHS[self.name](max(t_s, 0.0))
        wrist = WRIST + scale * offset + _tremor(t_s, self.seed)
        shoulder = WRIST + scale * SHOULDER_FROM_WRIST
        hand = rotation_from_vector(turn) @ PALM_DOWN @ rotation_from_vector(np.array([self.roll, 0.0, 0.0]))
        if self.name == "elbow_swing":
            return self._swung(shoulder, swivel, hand)
        return BodyPose(shoulder, self._elbow(shoulder, wrist), wrist, hand, openness)

    def _elbow(self, shoulder: Array, wrist: Array) -> Array:
        """The elbow that hangs down, a little outwards."""
        reach = wrist - shoulder
        distance = float(np.linalg.norm(reach))
        along = (self.upper_arm_m**2 - self.forearm_m**2 + distance**2) / (2.0 * distance)
        height = self.upper_arm_m**2 - along**2
        if height <= 0:
            raise ConfigError(f"the filmed arm cannot reach {distance:.3f} m; use a longer arm or a smaller motion")
        axis = reach / distance
        down = np.array([0.0, 0.25, -1.0])
        out = down - (down @ axis) * axis
        elbow: Array = shoulder + along * axis + math.sqrt(height) * out / np.linalg.norm(out)
        return elbow

    def _swung(self, shoulder: Array, angle: float, hand: Array) -> BodyPose:
        """The elbow at rest, forearm and hand turned about it by an angle in rad, in the plane of the bent arm."""
        elbow = self._elbow(shoulder, WRIST)
        hinge = np.cross(WRIST - elbow, shoulder - elbow)
        swing = rotation_from_vector(angle * hinge / np.linalg.norm(hinge))
        return BodyPose(shoulder, elbow, elbow + swing @ (WRIST - elbow), swing @ hand, 0.0)


Path = Callable[[float], tuple[Array, Array, float, float]]  # offset, turn, openness, swing


def _carry(t_s: float) -> tuple[Array, Array, float, float]:
    table, phase = np.array(_CARRY), math.fmod(t_s, _CARRY[-1][0])
    k = int(np.sum(table[1:-1, 0] <= phase))
    a, b = table[k], table[k + 1]
    at = a[1:] + minimum_jerk((phase - a[0]) / (b[0] - a[0])) * (b[1:] - a[1:])
    return at[:3], np.array([0.0, 0.0, math.radians(at[3])]), _opened(phase, _CARRY_OPENINGS_S), 0.0


def _turn(t_s: float) -> tuple[Array, Array, float, float]:
    """The hand about x, y and z, one after the other, there and back."""
    axis = int(t_s / 1.7) % 3
    reach = math.radians((40.0, 30.0, 30.0)[axis])
    return np.zeros(3), reach * math.sin(2.0 * math.pi * (t_s % 1.7) / 1.7) * np.eye(3)[axis], 0.0, 0.0


def _elbow_swing(t_s: float) -> tuple[Array, Array, float, float]:
    """The forearm through 90 degrees, most of them down and outwards."""
    there = 0.5 - 0.5 * math.cos(2.0 * math.pi * t_s / 3.0)
    return np.zeros(3), np.zeros(3), 0.0, math.radians(25.0 - 90.0 * there)


def _hold(_t_s: float) -> tuple[Array, Array, float, float]:
    return np.zeros(3), np.zeros(3), 0.0, 0.0


def _toggle(t_s: float) -> tuple[Array, Array, float, float]:
    return np.zeros(3), np.zeros(3), _opened(math.fmod(t_s, _TOGGLE_PERIOD_S), _TOGGLE_OPENINGS_S), 0.0


_PATHS: dict[FilmMotion, Path] = {
    "carry": _carry,
    "turn": _turn,
    "elbow_swing": _elbow_swing,
    "hold": _hold,
    "toggle": _toggle,
}


def _opened(t_s: float, openings_s: tuple[float, ...]) -> float:
    since = [t_s - start for start in openings_s]
    return max(minimum_jerk(s / OPENING_S) - minimum_jerk((s - OPENING_S - OPEN_S) / OPENING_S) for s in since)


def _tremor(t_s: float, seed: int) -> Array:
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (len(TREMOR_HZ), 3))
    tremor: Array = TREMOR_M * np.mean(np.sin(2.0 * np.pi * np.array(TREMOR_HZ)[:, None] * t_s + phases), axis=0)
    return tremor
