"""Where the target is between hand samples: a course in time, onto which it glides without a jump."""

import math

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.config import ControlConfig
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits

SHORTEST_S = 0.01  # of the interval between two samples, when it tells a velocity
MEMORY = 0.3  # share of the newest deviation in their mean: about three count
BY_CHANCE, FOR_SURE = 0.2, 0.5  # how much of their mean square deviations have in common from noise alone; in motion
NOTHING = 1e-18  # m² or rad²


class FreeCourse:
    """A target (n,) of any kind as it moves between hand samples.

    An alpha-beta estimate makes each sample a straight course in time, carried on for at most `predict_ms` beyond the
    sample. The target glides onto every new course, critically damped and without a jump of position or velocity, and
    follows a steady one without lag. Samples that deviate now to this side and now to that are noise, and hardly count;
    the more they deviate to one side, the more the estimate goes along with them.
    """

    def __init__(self, size: int, config: ControlConfig) -> None:
        self._predict_ns = round(config.predict_ms * NS_PER_MS)
        rest = np.array([config.position_gain, config.velocity_gain, config.glide_rad_s])
        moving = [config.moving_position_gain, config.moving_velocity_gain, config.moving_glide_rad_s]
        self._at_rest, self._in_motion = rest, np.maximum(moving, rest)
        self.reset(0, np.zeros(size))

    def reset(self, t_ns: int, q: Array) -> None:
        """A target that rests at `q` (n,) since `t_ns`."""
        zero = np.zeros(len(q))
        self._t_ns, self._q, self._dq = t_ns, q.copy(), zero
        self._since_ns, self._off, self._off_rate = t_ns, zero, zero
        self._deviation, self._square, self._glide = zero, 0.0, float(self._at_rest[2])
        self._prepare()

    def aim(self, t_ns: int, q: Array, now_ns: int, *, moving: bool = True) -> None:
        """A new sample of the target (n,) for the time `t_ns`, later than the last, known at `now_ns`.

        A target that does not move by itself, but only because it is held near the arm, has no course.
        """
        elapsed = (t_ns - self._t_ns) / NS_PER_S
        if elapsed <= 0:
            return
        expected = self._q + self._dq * min(elapsed, self._predict_ns / NS_PER_S)
        error = q - expected
        position_gain, velocity_gain, glide = self._gains(error)
        estimate = expected + position_gain * error
        rate = velocity_gain / max(elapsed, SHORTEST_S)
        velocity = self._dq + rate * error if moving else np.zeros(len(q))
        self._turn_to(t_ns, estimate, self._bounded(estimate, velocity), now_ns, glide)

    def at(self, now_ns: int) -> tuple[Array, Array]:
        """The target's position (n,), inside the limits if it has any, and velocity (n,) per s at `now_ns`."""
        if now_ns - self._t_ns > self._predict_ns and self._dq.any():
            end_ns = self._t_ns + self._predict_ns
            self._turn_to(end_ns, self._line(end_ns), np.zeros(len(self._q)), end_ns, self._glide)
        return self._kept(*self._glided(now_ns))

    def _gains(self, error: Array) -> list[float]:
        """The gains of position and velocity, and the glide, for the newest deviation (n,)."""
        self._deviation = self._deviation + MEMORY * (error - self._deviation)
        self._square += MEMORY * (float(error @ error) - self._square)
        common = float(self._deviation @ self._deviation) / (self._square + NOTHING)
        share = min(max((common - BY_CHANCE) / (FOR_SURE - BY_CHANCE), 0.0), 1.0)
        gains: list[float] = (self._at_rest + share * (self._in_motion - self._at_rest)).tolist()
        return gains

    def _turn_to(self, t_ns: int, q: Array, dq: Array, now_ns: int, glide: float) -> None:
        """Take a new course from `now_ns`; what the target is off it decays."""
        here, rate = (np.array(values) for values in self._glided(now_ns))
        self._glide = glide
        self._t_ns, self._q, self._dq = t_ns, q, dq
        self._since_ns, self._off, self._off_rate = now_ns, here - self._line(now_ns), rate - dq
        self._prepare()

    def _prepare(self) -> None:
        """For every number its place and speed, what it is off, and how that begins to decay."""
        push = self._off_rate + self._glide * self._off
        self._numbers = list(zip(self._q.tolist(), self._dq.tolist(), self._off.tolist(), push.tolist(), strict=True))

    def _line(self, now_ns: int) -> Array:
        line: Array = self._q + self._dq * ((now_ns - self._t_ns) / NS_PER_S)
        return line

    def _glided(self, now_ns: int) -> tuple[list[float], list[float]]:
        t, since, glide = (now_ns - self._t_ns) / NS_PER_S, max(now_ns - self._since_ns, 0) / NS_PER_S, self._glide
        decay = math.exp(-glide * since)
        places, speeds = [], []
        for q, dq, off, push in self._numbers:
            left = decay * (off + since * push)
            places.append(q + dq * t + left)
            speeds.append(dq + decay * push - glide * left)
        return places, speeds

    def _kept(self, q: list[float], dq: list[float]) -> tuple[Array, Array]:
        """Place and speed inside the limits, if there are any."""
        return np.array(q), np.array(dq)

    def _bounded(self, _q: Array, dq: Array) -> Array:
        return dq


class Course(FreeCourse):
    """The course of joints (n,) in rad, which always stays where they can stop inside their limits."""

    def __init__(self, limits: JointLimits, config: ControlConfig) -> None:
        self._limits = limits
        self._fastest = TARGET_SPEED * limits.velocity
        # Further than this from its limits, a joint can stop from any speed.
        far = (self._fastest**2 / limits.acceleration + self._fastest * limits.acceleration / limits.jerk) / 2
        self._far = list(zip((limits.lower + far).tolist(), (limits.upper - far).tolist(), strict=True))
        super().__init__(len(limits.names), config)

    def _kept(self, q: list[float], dq: list[float]) -> tuple[Array, Array]:
        """Inside the limits, with a velocity (n,) from which the joints can stop there."""
        places, speeds = np.array(q), np.array(dq)
        if self._is_far(q):
            return places, np.minimum(np.maximum(speeds, -self._fastest), self._fastest)
        inside = np.minimum(np.maximum(places, self._limits.lower), self._limits.upper)
        return inside, self._bounded(inside, speeds)

    def _bounded(self, q: Array, dq: Array) -> Array:
        """A velocity (n,) from which the joints can stop inside their limits."""
        up = down = self._fastest
        if not self._is_far(q.tolist()):
            up = np.minimum(up, self._limits.stoppable(self._limits.upper - q))
            down = np.minimum(down, self._limits.stoppable(q - self._limits.lower))
        bounded: Array = np.minimum(np.maximum(dq, -down), up)
        return bounded

    def _is_far(self, q: list[float]) -> bool:
        """Whether all joints are where they can stop inside their limits from any speed."""
        return all(low <= here <= high for here, (low, high) in zip(q, self._far, strict=True))
