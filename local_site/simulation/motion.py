"""What the simulated operator does: the pose of the arm as a function of time, and when the hand opens."""

import math

import numpy as np

from common.errors import ConfigError
from common.geometry import Array, rotation_from_vector, skew
from local_site.simulation.body import BodyPose
from local_site.simulation.config import BodyConfig, MotionConfig
from local_site.simulation.hand_paths import PATHS

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


class Motion:
    """One operator's motion, a pure function of the time since its start; ConfigError when the arm is too short."""

    def __init__(self, config: MotionConfig, body: BodyConfig, seed: int) -> None:
        self._config = config
        self._upper_arm, self._forearm = body.upper_arm_length, body.forearm_length
        self._path = PATHS[config.name]
        self._shoulder = np.array(config.shoulder)
        self._start = np.array(config.wrist)
        self._phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (len(TREMOR_HZ), 3))
        for t_s in np.arange(0.0, CHECKED_S, 0.2):
            self.pose(config.still_s + t_s)

    def pose(self, t_s: float) -> BodyPose:
        """The pose at a time; ConfigError when the arm cannot reach so far from its shoulder."""
        state = self._path.at(max(t_s - self._config.still_s, 0.0))
        wrist = self._start + state.offset + self._tremor(t_s)
        roll = rotation_from_vector(np.array([START_ROLL + OPENING_ROLL * state.openness, 0.0, 0.0]))
        return BodyPose(
            shoulder=self._shoulder,
            elbow=self._elbow(wrist),
            wrist=wrist,
            operator_R_hand=rotation_from_vector(state.turn) @ START_HAND @ roll,
            openness=state.openness,
        )

    def openings_until(self, t_s: float) -> int:
        """How often the hand has begun to open."""
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
        down = np.array([0.0, 0.0, -1.0])
        first = down - (down @ axis) * axis
        sine = math.sqrt(float(first @ first))
        if sine < LEAST_SINE:
            raise ConfigError("the wrist is straight above or below the shoulder; move one of them aside")
        first /= sine
        swivel = math.radians(self._config.swivel_deg)
        out = math.cos(swivel) * first + math.sin(swivel) * (skew(axis) @ first)
        elbow: Array = self._shoulder + along * axis + math.sqrt(a * a - along * along) * out
        return elbow

    def _tremor(self, t_s: float) -> Array:
        if not self._config.tremor_mm:
            return np.zeros(3)
        turns = 2.0 * np.pi * np.array(TREMOR_HZ)[:, None] * t_s + self._phases
        tremor: Array = self._config.tremor_mm * 1e-3 * np.mean(np.sin(turns), axis=0)
        return tremor
