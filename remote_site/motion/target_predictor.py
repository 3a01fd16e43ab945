"""The predicted target between hand samples: an alpha-beta estimate, joined to the one before without a jump; pure."""

import math
from typing import Protocol

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits, stoppable
from remote_site.motion.config import ControlConfig

SHORTEST_S = 0.01  # least interval between two samples from which a velocity is estimated
MEMORY = 0.3  # weight of the newest deviation in the running means: about three count
NOISE_CORRELATION, MOTION_CORRELATION = 0.2, 0.5  # squared mean deviation over mean squared: of noise, of motion
NOTHING = 1e-18  # m² or rad²

Numbers = list[float]


class Bounds(Protocol):
    """The bounds of a predicted target."""

    def clamp(self, q: Numbers, dq: Numbers) -> tuple[Numbers, Numbers]:
        """Position and velocity within the bounds."""

    def convergence(self, wanted: float, off: Numbers, dq_off: Numbers) -> float:
        """The convergence rate in rad/s, `wanted` or slower, for what position and velocity have to lose."""


class Unbounded:
    """No bounds, as for the pose of the tool."""

    def clamp(self, q: Numbers, dq: Numbers) -> tuple[Numbers, Numbers]:
        """The same."""
        return q, dq

    def convergence(self, wanted: float, off: Numbers, dq_off: Numbers) -> float:  # noqa: ARG002  # the protocol's
        """The wanted rate."""
        return wanted


class JointBounds:
    """Joints (n,) in rad stay where they can stop inside their limits, and converge within their acceleration."""

    def __init__(self, limits: JointLimits, slowest: float) -> None:
        fastest = TARGET_SPEED * limits.velocity
        # Further than this from its limits, a joint can stop from any speed.
        far = (fastest**2 / limits.acceleration + fastest * limits.acceleration / limits.jerk) / 2
        columns = limits.lower, limits.lower + far, limits.upper - far, limits.upper, fastest
        dynamics = limits.acceleration, limits.jerk
        self._joints = list(zip(*(column.tolist() for column in (*columns, *dynamics)), strict=True))
        self._acceleration = limits.acceleration.tolist()
        self._slowest = slowest

    def convergence(self, wanted: float, off: Numbers, dq_off: Numbers) -> float:
        """The rate that every joint can follow: one that cannot would lag and take the tool off the common path."""
        rate = wanted
        for away, step, most in zip(map(abs, off), map(abs, dq_off), self._acceleration, strict=True):
            if rate * (rate * away + 2 * step) > most:  # the acceleration at the start, at worst
                rate = (math.sqrt(step * step + most * away) - step) / away if away > NOTHING else most / (2 * step)
        return max(rate, self._slowest)

    def clamp(self, q: Numbers, dq: Numbers) -> tuple[Numbers, Numbers]:
        """Positions inside the limits, with velocities from which the joints can stop there."""
        positions, velocities = [], []
        for position, velocity, joint in zip(q, dq, self._joints, strict=True):
            lower, least, most, upper, up, acceleration, jerk = joint
            inside, down = position, up
            if not least <= position <= most:
                inside = min(max(position, lower), upper)
                up = min(up, stoppable(upper - inside, acceleration, jerk))
                down = min(down, stoppable(inside - lower, acceleration, jerk))
            positions.append(inside)
            velocities.append(up if velocity > up else -down if velocity < -down else velocity)
        return positions, velocities


class TargetPredictor:
    """A target (n,) of any kind as it moves between hand samples.

    Each sample gives a straight line in time by an alpha-beta estimate, extrapolated for at most `predict_ms` after the
    sample arrived; for 0 not at all. The target converges to every new line, critically damped and without a jump of
    position or velocity, and follows a steady motion without lag. The gains rise from those at rest to those in motion
    with the correlation of successive deviations: deviations to alternating sides are noise and hardly count.
    """

    def __init__(self, size: int, config: ControlConfig, bounds: Bounds | None = None) -> None:
        self._predict_ns = round(config.predict_ms * NS_PER_MS)
        rest = config.position_gain, config.velocity_gain, config.glide_rad_s
        moving = config.moving_position_gain, config.moving_velocity_gain, config.moving_glide_rad_s
        self._gain_ranges = [(low, max(high, low) - low) for low, high in zip(rest, moving, strict=True)]
        self._bounds = bounds or Unbounded()
        self.reset(0, np.zeros(size))

    def reset(self, t_ns: int, q: Array) -> None:
        """A target that rests at `q` (n,) since `t_ns`."""
        self._t_ns = self._since_ns = self._sample_ns = self._end_ns = t_ns
        self._line = [(position, 0.0) for position in q.tolist()]  # position and velocity at the newest sample
        self._deviation, self._square, self._rate = [0.0] * len(q), 0.0, self._gain_ranges[2][0]
        # of every number: position and velocity on the line, its offset from that, and the offset's initial decay
        self._numbers = [(position, 0.0, 0.0, 0.0) for position in q.tolist()]

    def aim(self, t_ns: int, q: Array, now_ns: int, *, moving: bool = True) -> None:
        """Take a new sample of the target (n,) for the time `t_ns`, later than the last, known at `now_ns`.

        A target that moves only because it is held near the arm (not `moving`) is not extrapolated.
        """
        if t_ns <= self._sample_ns:
            return
        elapsed, ended = (t_ns - self._sample_ns) / NS_PER_S, t_ns > self._end_ns
        expected = self._at_end() if ended else [position + velocity * elapsed for position, velocity in self._line]
        error = [new - old for new, old in zip(q.tolist(), expected, strict=True)]
        position_gain, velocity_gain, rate = self._gains(error)
        estimate = [old + position_gain * off for old, off in zip(expected, error, strict=True)]
        gain = velocity_gain / max(elapsed, SHORTEST_S)
        before = [0.0 if ended else velocity for _, velocity in self._line]
        velocities = [velocity + gain * off if moving else 0.0 for velocity, off in zip(before, error, strict=True)]
        velocities = self._bounds.clamp(estimate, velocities)[1]
        self._line = list(zip(estimate, velocities, strict=True))
        self._sample_ns, self._end_ns = t_ns, now_ns + self._predict_ns if self._predict_ns else t_ns
        self._turn_to(t_ns, estimate, velocities, now_ns, rate)

    def at(self, now_ns: int) -> tuple[Array, Array]:
        """The target's position (n,) and velocity (n,) per s at `now_ns`, within its bounds."""
        if now_ns > self._end_ns and any(number[1] for number in self._numbers):
            positions = self._at_end()
            self._turn_to(self._end_ns, positions, [0.0] * len(positions), self._end_ns, self._rate)
        positions, velocities = self._bounds.clamp(*self._converging(now_ns))
        return np.array(positions), np.array(velocities)

    def _at_end(self) -> Numbers:
        """Where the extrapolation ends."""
        predicted_s = (self._end_ns - self._sample_ns) / NS_PER_S
        return [position + velocity * predicted_s for position, velocity in self._line]

    def _gains(self, error: Numbers) -> Numbers:
        """The gains of position and velocity, and the convergence rate, for the newest deviation (n,)."""
        self._deviation = [old + MEMORY * (new - old) for new, old in zip(error, self._deviation, strict=True)]
        self._square += MEMORY * (_square(error) - self._square)
        correlation = _square(self._deviation) / (self._square + NOTHING)
        motion = min(max((correlation - NOISE_CORRELATION) / (MOTION_CORRELATION - NOISE_CORRELATION), 0.0), 1.0)
        return [low + motion * more for low, more in self._gain_ranges]

    def _turn_to(self, t_ns: int, q: Numbers, dq: Numbers, now_ns: int, rate: float) -> None:
        """Take a new line from `now_ns`; the target's offset from it decays."""
        since = (now_ns - t_ns) / NS_PER_S
        here, moving = self._converging(now_ns)
        off = [at - (position + velocity * since) for at, position, velocity in zip(here, q, dq, strict=True)]
        dq_off = [at - velocity for at, velocity in zip(moving, dq, strict=True)]
        rate = self._bounds.convergence(rate, off, dq_off)
        columns = zip(q, dq, off, dq_off, strict=True)
        self._numbers = [(position, velocity, away, step + rate * away) for position, velocity, away, step in columns]
        self._t_ns, self._since_ns, self._rate = t_ns, now_ns, rate

    def _converging(self, now_ns: int) -> tuple[Numbers, Numbers]:
        t, since, rate = (now_ns - self._t_ns) / NS_PER_S, max(now_ns - self._since_ns, 0) / NS_PER_S, self._rate
        decay = math.exp(-rate * since)
        positions, velocities = [], []
        for q, dq, off, push in self._numbers:
            left = decay * (off + since * push)
            positions.append(q + dq * t + left)
            velocities.append(dq + decay * push - rate * left)
        return positions, velocities


def joint_target_predictor(limits: JointLimits, config: ControlConfig) -> TargetPredictor:
    """The predictor of a joint target (n,) in rad, kept where the joints can stop inside their limits."""
    return TargetPredictor(len(limits.names), config, JointBounds(limits, config.glide_rad_s))


def _square(numbers: Numbers) -> float:
    return sum(number * number for number in numbers)
