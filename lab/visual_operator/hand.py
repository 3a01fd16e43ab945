"""The operator's hand: movements of minimum jerk one after the other, openings, and a person's motor noise."""

from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter

from common.geometry import Array, rotation_from_vector, vector_from_rotation

NOISE_HZ = 100.0
OPENING_S, OPEN_S = 0.2, 0.5
PEAK = 1.875  # of the speed of a minimum-jerk movement, over its mean


@dataclass(frozen=True, slots=True)
class Motor:
    """A person's limits: peak speeds, the least time of a movement, and the noise of the hand (standard deviations).

    The noise wanders about within `noise_s`, along and about each axis.
    """

    speed_m_s: float = 0.3
    turn_rad_s: float = 1.5
    least_s: float = 0.35
    noise_m: float = 0.002
    noise_rad: float = np.radians(1.5)
    noise_s: float = 0.25
    reaction_s: float = 0.25


@dataclass(frozen=True, slots=True)
class TimedMovement:
    """From one offset (3,) m and turn (3, 3) to another, between two times, s."""

    start_s: float
    end_s: float
    offsets: tuple[Array, Array]
    turns: tuple[Array, Array]

    def at(self, t_s: float) -> tuple[Array, Array]:
        """The offset and the turn at a time."""
        u = min(max((t_s - self.start_s) / max(self.end_s - self.start_s, 1e-9), 0.0), 1.0)
        u = u * u * u * (10.0 + u * (6.0 * u - 15.0))
        a, b = self.turns
        turn = rotation_from_vector(u * vector_from_rotation(b @ a.T)) @ a
        return self.offsets[0] + u * (self.offsets[1] - self.offsets[0]), turn


@dataclass
class ScriptedHand:
    """The hand's motion, as the simulated operator's `Path`: from the start pose, in the operator frame."""

    motor: Motor
    seed: int
    openings_s: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._movement = TimedMovement(0.0, 0.0, (np.zeros(3), np.zeros(3)), (np.eye(3), np.eye(3)))
        self._rng = np.random.default_rng(self.seed)
        self._noise = np.empty((0, 6))
        self._state = np.zeros((2, 6))

    def move(self, start_s: float, offset: Array, turn: Array) -> float:
        """Begin a movement by (3,) m and (3, 3) from where the last one ends; when it ends, s."""
        now, turned = self._movement.at(start_s)
        angle = float(np.linalg.norm(vector_from_rotation(turn)))
        motor = self.motor
        needs = PEAK * max(float(np.linalg.norm(offset)) / motor.speed_m_s, angle / motor.turn_rad_s)
        end_s = start_s + max(needs, motor.least_s)
        self._movement = TimedMovement(start_s, end_s, (now, now + offset), (turned, turn @ turned))
        return end_s

    def open_at(self, start_s: float) -> float:
        """Open the hand, and close it; when it is closed again, s."""
        self.openings_s.append(start_s)
        return start_s + 2 * OPENING_S + OPEN_S

    def aim(self) -> tuple[Array, Array]:
        """Return where the last movement ends, without noise: offset and turn."""
        return self._movement.offsets[1], self._movement.turns[1]

    def at(self, t_s: float) -> tuple[Array, Array, float]:
        """The hand's offset (3,) m, its turn (3,) as a rotation vector, and its openness."""
        offset, turn = self._movement.at(t_s)
        noise = self._noise_at(t_s)
        turned = rotation_from_vector(noise[3:]) @ turn
        openness = max((_openness(t_s - start) for start in self.openings_s), default=0.0)
        return offset + noise[:3], vector_from_rotation(turned), openness

    def openings_until(self, t_s: float) -> int:
        """Count how often the hand has begun to open."""
        return sum(t_s >= start for start in self.openings_s)

    def _noise_at(self, t_s: float) -> Array:
        at = t_s * NOISE_HZ
        while at + 2 > len(self._noise):
            self._noise = np.concatenate([self._noise, self._more_noise()])
        k = int(at)
        part = at - k
        return np.asarray((1 - part) * self._noise[k] + part * self._noise[k + 1])

    def _more_noise(self) -> Array:
        """Ten seconds more: white noise through two low passes, scaled to the standard deviation asked for."""
        motor = self.motor
        keep = np.exp(-1.0 / (NOISE_HZ * motor.noise_s))
        white = self._rng.standard_normal((round(10 * NOISE_HZ), 6))
        for k in range(2):
            first = keep * self._state[k]
            white, last = lfilter([1.0 - keep], [1.0, -keep], white, axis=0, zi=first[None])
            self._state[k] = last[0] / keep
        power = (1 - keep) ** 4 * (1 + keep**2) / (1 - keep**2) ** 3
        return np.asarray(white / np.sqrt(power) * ([motor.noise_m] * 3 + [motor.noise_rad] * 3))


def _openness(since_s: float) -> float:
    def rise(t_s: float) -> float:
        u = min(max(t_s / OPENING_S, 0.0), 1.0)
        return u * u * u * (10.0 + u * (6.0 * u - 15.0))

    return rise(since_s) - rise(since_s - OPENING_S - OPEN_S)
