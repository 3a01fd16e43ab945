"""Where the target is between hand samples: a course in time, onto which it glides without a jump."""

import math

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits, stoppable
from remote_site.motion.config import ControlConfig

SHORTEST_S = 0.01  # of the interval between two samples, when it tells a velocity
MEMORY = 0.3  # share of the newest deviation in their mean: about three count
BY_CHANCE, FOR_SURE = 0.2, 0.5  # how much of their mean square deviations have in common from noise alone; in motion
NOTHING = 1e-18  # m² or rad²


class TargetPredictor:
    """A target (n,) of any kind as it moves between hand samples.

    An alpha-beta estimate makes each sample a straight course in time, carried on for at most `predict_ms` after it has
    come, however long it took; for 0 not at all. The target glides onto every new course, critically damped and without
    a jump of position or velocity, and follows a steady one without lag. Samples that deviate now to this side and now
    to that are noise, and hardly count; the more they deviate to one side, the more the estimate goes along with them.
    """

    def __init__(self, size: int, config: ControlConfig) -> None:
        self._predict_ns = round(config.predict_ms * NS_PER_MS)
        rest = config.position_gain, config.velocity_gain, config.glide_rad_s
        moving = config.moving_position_gain, config.moving_velocity_gain, config.moving_glide_rad_s
        self._gain_ranges = [(low, max(high, low) - low) for low, high in zip(rest, moving, strict=True)]
        self._resting_glide = config.glide_rad_s
        self.reset(0, np.zeros(size))

    def reset(self, t_ns: int, q: Array) -> None:
        """A target that rests at `q` (n,) since `t_ns`."""
        self._t_ns = self._since_ns = self._sample_ns = self._end_ns = t_ns
        self._course = [(place, 0.0) for place in q.tolist()]  # place and speed at the newest sample
        self._deviation, self._square, self._glide = [0.0] * len(q), 0.0, self._resting_glide
        # of every number: the place and speed on the course, what it is off that, and how this begins to decay
        self._numbers = [(place, 0.0, 0.0, 0.0) for place in q.tolist()]

    def aim(self, t_ns: int, q: Array, now_ns: int, *, moving: bool = True) -> None:
        """A new sample of the target (n,) for the time `t_ns`, later than the last, known at `now_ns`.

        A target that does not move by itself, but only because it is held near the arm, has no course.
        """
        if t_ns <= self._sample_ns:
            return
        elapsed, ended = (t_ns - self._sample_ns) / NS_PER_S, t_ns > self._end_ns
        expected = self._at_end() if ended else [place + speed * elapsed for place, speed in self._course]
        error = [new - old for new, old in zip(q.tolist(), expected, strict=True)]
        position_gain, velocity_gain, glide = self._gains(error)
        estimate = [old + position_gain * off for old, off in zip(expected, error, strict=True)]
        rate = velocity_gain / max(elapsed, SHORTEST_S)
        carried = [0.0 if ended else speed for _, speed in self._course]
        speeds = [speed + rate * off if moving else 0.0 for speed, off in zip(carried, error, strict=True)]
        speeds = self._kept(estimate, speeds)[1]
        self._course = list(zip(estimate, speeds, strict=True))
        self._sample_ns, self._end_ns = t_ns, now_ns + self._predict_ns if self._predict_ns else t_ns
        self._turn_to(t_ns, estimate, speeds, now_ns, glide)

    def at(self, now_ns: int) -> tuple[Array, Array]:
        """The target's position (n,), inside the limits if it has any, and velocity (n,) per s at `now_ns`."""
        if now_ns > self._end_ns and any(number[1] for number in self._numbers):
            places = self._at_end()
            self._turn_to(self._end_ns, places, [0.0] * len(places), self._end_ns, self._glide)
        places, speeds = self._kept(*self._glided(now_ns))
        return np.array(places), np.array(speeds)

    def _at_end(self) -> list[float]:
        """Where the course ends."""
        carried_s = (self._end_ns - self._sample_ns) / NS_PER_S
        return [place + speed * carried_s for place, speed in self._course]

    def _gains(self, error: list[float]) -> list[float]:
        """The gains of position and velocity, and the glide, for the newest deviation (n,)."""
        self._deviation = [old + MEMORY * (new - old) for new, old in zip(error, self._deviation, strict=True)]
        self._square += MEMORY * (_square(error) - self._square)
        common = _square(self._deviation) / (self._square + NOTHING)
        share = min(max((common - BY_CHANCE) / (FOR_SURE - BY_CHANCE), 0.0), 1.0)
        return [low + share * more for low, more in self._gain_ranges]

    def _turn_to(self, t_ns: int, q: list[float], dq: list[float], now_ns: int, glide: float) -> None:
        """Take a new course from `now_ns`; what the target is off it decays."""
        since, numbers = (now_ns - t_ns) / NS_PER_S, []
        heres, movings = self._glided(now_ns)
        offs = [here - (place + speed * since) for here, place, speed in zip(heres, q, dq, strict=True)]
        steps = [moving - speed for moving, speed in zip(movings, dq, strict=True)]
        glide = self._bearable(glide, offs, steps)
        for place, speed, off, step in zip(q, dq, offs, steps, strict=True):
            numbers.append((place, speed, off, step + glide * off))
        self._t_ns, self._since_ns, self._glide, self._numbers = t_ns, now_ns, glide, numbers

    def _glided(self, now_ns: int) -> tuple[list[float], list[float]]:
        t, since, glide = (now_ns - self._t_ns) / NS_PER_S, max(now_ns - self._since_ns, 0) / NS_PER_S, self._glide
        decay = math.exp(-glide * since)
        places, speeds = [], []
        for q, dq, off, push in self._numbers:
            left = decay * (off + since * push)
            places.append(q + dq * t + left)
            speeds.append(dq + decay * push - glide * left)
        return places, speeds

    def _kept(self, q: list[float], dq: list[float]) -> tuple[list[float], list[float]]:
        """Place and speed inside the limits, if there are any."""
        return q, dq

    def _bearable(self, glide: float, offs: list[float], steps: list[float]) -> float:
        """The glide, or a slower one if limits ask for it; `offs` and `steps` are what place and speed have to lose."""
        del offs, steps
        return glide


class JointTargetPredictor(TargetPredictor):
    """The course of joints (n,) in rad, which always stays where they can stop inside their limits."""

    def __init__(self, limits: JointLimits, config: ControlConfig) -> None:
        fastest = TARGET_SPEED * limits.velocity
        # Further than this from its limits, a joint can stop from any speed.
        far = (fastest**2 / limits.acceleration + fastest * limits.acceleration / limits.jerk) / 2
        columns = limits.lower, limits.lower + far, limits.upper - far, limits.upper, fastest
        dynamics = limits.acceleration, limits.jerk
        self._joints = list(zip(*(column.tolist() for column in (*columns, *dynamics)), strict=True))
        self._most = limits.acceleration.tolist()
        super().__init__(len(limits.names), config)

    def _bearable(self, glide: float, offs: list[float], steps: list[float]) -> float:
        """As fast as every joint can: one that cannot would fall behind, and take the tool off the common way."""
        for off, step, most in zip(map(abs, offs), map(abs, steps), self._most, strict=True):
            if glide * (glide * off + 2 * step) > most:  # what the glide begins with, at worst
                glide = (math.sqrt(step * step + most * off) - step) / off if off > NOTHING else most / (2 * step)
        return max(glide, self._resting_glide)

    def _kept(self, q: list[float], dq: list[float]) -> tuple[list[float], list[float]]:
        """Inside the limits, with a velocity (n,) from which the joints can stop there."""
        places, speeds = [], []
        for place, speed, joint in zip(q, dq, self._joints, strict=True):
            lower, least, most, upper, up, acceleration, jerk = joint
            here, down = place, up
            if not least <= place <= most:
                here = min(max(place, lower), upper)
                up = min(up, stoppable(upper - here, acceleration, jerk))
                down = min(down, stoppable(here - lower, acceleration, jerk))
            places.append(here)
            speeds.append(up if speed > up else -down if speed < -down else speed)
        return places, speeds


def _square(numbers: list[float]) -> float:
    return sum(number * number for number in numbers)
