"""An offset from a joint target that decays, critically damped, in all joints alike; pure."""

import math
from collections.abc import Callable

import numpy as np

from remote_site.kinematics.joints import JointMotion

FASTEST_RAD_S = 10.0  # the decay rate
NOTHING_RAD = 1e-5

Rate = Callable[[float, list[float], list[float]], float]


class DecayingOffset:
    """Joins a motion to a target without a jump; `rate` finds one that all joints can follow."""

    def __init__(self, rate: Rate, dt: float) -> None:
        self._choose_rate, self._dt = rate, dt
        self.reset()

    def reset(self) -> None:
        """No offset."""
        self._rate, self._off, self._dq_off = 0.0, np.zeros(1), np.zeros(1)

    def begin(self, motion: JointMotion, target: JointMotion) -> None:
        """From the motion as it is, on to the target."""
        self._off, self._dq_off = motion.q - target.q, motion.dq - target.dq
        self._rate = self._choose_rate(FASTEST_RAD_S, self._off.tolist(), self._dq_off.tolist())

    def added_to(self, target: JointMotion) -> JointMotion:
        """The target's motion and what is left of the offset one tick later.

        Of x'' = -2 r x' - r² x the solution is x = exp(-r t) (x0 + t p) with p = x0' + r x0.
        """
        if self._rate == 0.0:
            return target
        rate, dt = self._rate, self._dt
        push, decay = self._dq_off + rate * self._off, math.exp(-rate * dt)
        left = self._off + dt * push
        off, dq_off = self._off, self._dq_off = decay * left, decay * (push - rate * left)
        if float(np.max(np.abs(off))) < NOTHING_RAD and float(np.max(np.abs(dq_off))) < NOTHING_RAD * rate:
            self.reset()
        return JointMotion(target.q + off, target.dq + dq_off, target.ddq - rate * (2 * dq_off + rate * off))
