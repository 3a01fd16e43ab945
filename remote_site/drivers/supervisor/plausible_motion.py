"""Plausible motion: joints are read no farther from their readings before than they can have moved since; pure."""

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array

NOISE_RAD = 0.05  # of a reading; as much as 13 ms that a stamp is off, at full speed
FASTER = 1.25  # times a joint's own speed: it overshoots, and a slow robot's clock is another


class PlausibleMotion:
    """Bounds the positions of joints with these own speeds (n,) rad/s, of a robot with this period.

    Every reading before counts, not the last alone: what drifts faster than a joint moves is no motion either. The
    bounds widen with time, so that a posture which stays is plausible once the joints had the time to get there.
    `unseen_ns` is how long nobody looked before a reading: its stamp may be off by as much.
    """

    def __init__(self, velocity: Array, period_s: float) -> None:
        self._fastest = FASTER * velocity
        self._noise = NOISE_RAD + self._fastest * period_s  # a slow robot's reading may be repeated under a new stamp
        self.restart()

    def restart(self) -> None:
        """Forget every reading: the next one may be anywhere."""
        self._least = np.full(len(self._fastest), -np.inf)
        self._most = np.full(len(self._fastest), np.inf)
        self._noted_ns = 0

    def bounds(self, t_ns: int, unseen_ns: int) -> tuple[Array, Array]:
        """The least and the largest plausible positions (n,) in rad at a time; infinite before the first reading."""
        way = self._fastest * ((max(t_ns - self._noted_ns, 0) + unseen_ns) / NS_PER_S)
        return self._least - way, self._most + way

    def note(self, q: Array, t_ns: int, unseen_ns: int) -> None:
        """Take a plausible reading `q` (n,) in rad, measured at `t_ns`."""
        least, most = self.bounds(t_ns, 0)
        off = self._noise + self._fastest * (unseen_ns / NS_PER_S)
        self._least, self._most = np.maximum(least, q - off), np.minimum(most, q + off)
        self._noted_ns = t_ns
