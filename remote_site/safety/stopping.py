"""The jerk-limited stop of every joint in closed form: the time-optimal motion to rest."""

import math
from typing import NamedTuple

import numpy as np

from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits

JointState = tuple[float, float, float]  # position, velocity, acceleration
Span = tuple[float, float]  # middle and reach
REST = 1e-12  # rad/s and rad/s²: what rounding leaves of a stop that has ended


class JointStop(NamedTuple):
    """One joint's stop: `jerk` for `first` seconds, none for `cruise`, `-jerk` for `last`, and it rests."""

    q: float
    v: float
    a: float
    jerk: float
    first: float
    cruise: float
    last: float

    @property
    def duration(self) -> float:
        """Time to rest in s."""
        return self.first + self.cruise + self.last

    @property
    def reverses(self) -> bool:
        """Return whether it reverses before it rests."""
        return self.v * self.jerk > 0.0

    @property
    def fastest(self) -> float:
        """An upper bound of the speed until rest."""
        return abs(self.v) + self.a * self.a / abs(2 * self.jerk or 1.0)

    @property
    def end(self) -> float:
        """The position at rest."""
        state = advance((self.q, self.v, self.a), self.jerk, self.first)
        if self.cruise:
            state = advance(state, 0.0, self.cruise)
        return advance(state, -self.jerk, self.last)[0]

    def at(self, t: float) -> JointState:
        """Position, velocity and acceleration `t` seconds after the onset."""
        state = (self.q, self.v, self.a)
        for jerk, duration in self._phases():
            if t < duration:
                return advance(state, jerk, t)
            state = advance(state, jerk, duration)
            t -= duration
        return state[0], 0.0, 0.0

    def extent(self) -> tuple[float, float]:
        """The lowest and the highest position until rest."""
        state = (self.q, self.v, self.a)
        low = high = self.q
        for jerk, duration in self._phases():
            for t in (*_turns(state, jerk, duration), duration):
                position = advance(state, jerk, t)[0]
                low, high = min(low, position), max(high, position)
            state = advance(state, jerk, duration)
        return low, high

    def _phases(self) -> tuple[tuple[float, float], ...]:
        return (self.jerk, self.first), (0.0, self.cruise), (-self.jerk, self.last)


def advance(state: JointState, jerk: float, t: float) -> JointState:
    """The state after `t` seconds of constant jerk."""
    q, v, a = state
    return q + t * (v + t * (a / 2 + t * jerk / 6)), v + t * (a + t * jerk / 2), a + t * jerk


def joint_stop(state: JointState, acceleration: float, jerk: float) -> JointStop:
    """The quickest stop of one joint within its acceleration (rad/s²) and jerk (rad/s³) limits."""
    q, v, a = state
    if -REST < v < REST and -REST < a < REST:
        return JointStop(q, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    coasting = v + a * abs(a) / (2 * jerk)  # the velocity left when the acceleration alone is taken back
    side = 1.0 if coasting >= 0.0 else -1.0
    toward, along = side * v, side * a
    peak = math.sqrt(max(jerk * toward + along * along / 2, 0.0))
    cruise = 0.0
    if peak > acceleration:
        peak = acceleration
        cruise = max((toward + (along * along - 2 * peak * peak) / (2 * jerk)) / peak, 0.0)
    return JointStop(q, v, a, -side * jerk, max((along + peak) / jerk, 0.0), cruise, peak / jerk)


def longest_stop(velocity: float, acceleration: float, jerk: float) -> float:
    """The longest stop in s that a joint's limits (rad/s, rad/s², rad/s³) allow.

    It begins where the greatest speed is reached once the acceleration is taken back, from the greatest acceleration
    for which it is not exceeded backwards meanwhile.
    """
    rising = min(acceleration, 2 * math.sqrt(jerk * velocity))
    return rising / jerk + joint_stop((0.0, velocity, 0.0), acceleration, jerk).duration


def span(state: JointState, acceleration: float, jerk: float) -> Span:
    """A middle and a reach that bound all positions of a joint's stop; quicker to compute than the stop itself.

    The travel is at most the greatest speed times the first phase and half of the others, with the longest possible
    phases: once the acceleration has turned, the speed falls below the line to rest. Unless the stop reverses, it is
    all to one side.
    """
    q, v, a = state
    fastest = abs(v) + a * a / (2 * jerk)
    travel = fastest * ((abs(a) + acceleration) / jerk + fastest / (2 * acceleration))
    coasting = v + a * abs(a) / (2 * jerk)
    if v * coasting < 0.0:
        return q, travel
    return q + math.copysign(travel / 2, v + coasting), travel / 2


def stops(motion: JointMotion, limits: JointLimits) -> list[JointStop]:
    """The stop of every joint from a motion."""
    states = zip(motion.q.tolist(), motion.dq.tolist(), motion.ddq.tolist(), strict=True)
    bounds = zip(limits.acceleration.tolist(), limits.jerk.tolist(), strict=True)
    return [joint_stop(state, *most) for state, most in zip(states, bounds, strict=True)]


def stopping(motion: JointMotion, limits: JointLimits, t: float) -> JointMotion:
    """The motion `t` seconds (at least 0) after a stop began."""
    q, dq, ddq = zip(*(stop.at(t) for stop in stops(motion, limits)), strict=True)
    return JointMotion(np.array(q), np.array(dq), np.array(ddq))


def stop_time(motion: JointMotion, limits: JointLimits) -> float:
    """Seconds until the last joint rests, when the stop begins now."""
    return max(stop.duration for stop in stops(motion, limits))


def _turns(state: JointState, jerk: float, duration: float) -> list[float]:
    """The instants within a phase at which the velocity is zero."""
    _, v, a = state
    if jerk == 0.0:
        roots = [-v / a] if a != 0.0 else []
    else:
        discriminant = a * a - 2 * jerk * v
        if discriminant < 0.0:
            return []
        root = math.sqrt(discriminant)
        roots = [(-a - root) / jerk, (-a + root) / jerk]
    return [t for t in roots if 0.0 < t < duration]
