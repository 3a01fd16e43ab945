"""Estimates how a target moves from its samples: position, velocity, a decaying acceleration, its haste; pure."""

import math
from collections.abc import Callable
from typing import NamedTuple

from common.clock import NS_PER_S
from common.geometry import Array
from remote_site.motion.config import ControlConfig
from remote_site.motion.gains import Gains

SHORTEST_S = 0.01  # least interval between two samples from which a velocity is estimated
CORRELATION_S = 0.2  # time constant with which an acceleration decays, as a hand's does
INTERVAL_MEMORY = 1 / 16  # weight of the newest interval in the usual one
CALM, HURRIED = 0.15, 0.4  # of the joints' accelerations: full prediction below, the least above
HURRY_MEMORY_S = 0.3  # how long a hurry is remembered: between its two accelerations a movement has none
LEAST_EXTRAPOLATED = 0.3  # of the velocity that is extrapolated in a hurry

Numbers = list[float]
State = tuple[float, float, float]  # position, velocity and acceleration
Clamp = Callable[[Numbers, Numbers], tuple[Numbers, Numbers]]


class Transition(NamedTuple):
    """The change of a state in a time, by Singer's model of a manoeuvring target: the acceleration decays."""

    seconds: float
    way: float  # for each unit of acceleration
    velocity: float
    acceleration: float

    @classmethod
    def over(cls, seconds: float) -> "Transition":
        """The transition over this time, which may be negative."""
        decay = math.exp(-seconds / CORRELATION_S)
        gained = CORRELATION_S * (1.0 - decay)
        return cls(seconds, CORRELATION_S * (seconds - gained), gained, decay)

    def of(self, states: list[State]) -> list[State]:
        """The states afterwards."""
        seconds, way, gained, decay = self
        return [(x + seconds * v + way * a, v + gained * a, decay * a) for x, v, a in states]


class TargetEstimator:
    """An alpha-beta-gamma filter with the gains of `gains.py`; `clamp` keeps position and velocity within bounds."""

    def __init__(self, config: ControlConfig, clamp: Clamp) -> None:
        self._gains, self._clamp = Gains(config), clamp
        self.rate_at_rest = self._gains.rate_at_rest
        self.reset(0, [])

    def reset(self, t_ns: int, q: Numbers) -> None:
        """A target at rest at `q` (n,)."""
        self.sample_ns, self._usual_s = t_ns, 0.0
        self.states: list[State] = [(position, 0.0, 0.0) for position in q]
        self._gains.reset(len(q))

    def update(self, t_ns: int, q: Array, rested: Numbers | None, *, moving: bool, settled: bool) -> float:
        """Correct the estimate by a sample (n,) later than the last; return the convergence rate in rad/s it deserves.

        `rested` is where the target has come to rest meanwhile, None while it moves. A target that only seems to move
        (not `moving`) has no velocity; while it has only just begun to (not `settled`), no acceleration is learned.
        """
        elapsed = (t_ns - self.sample_ns) / NS_PER_S
        expected = Transition.over(elapsed).of(self.states) if rested is None else [(at, 0.0, 0.0) for at in rested]
        error = [new - old for new, (old, _, _) in zip(q.tolist(), expected, strict=True)]
        gains = self._gains.update(error)
        position_gain = gains.position if rested is None else 1.0
        acceleration_gain = gains.acceleration if settled else 0.0
        interval = max(elapsed, SHORTEST_S)
        usual = interval if rested is not None else self._usual_interval(interval)
        # After a lost sample the deviation tells more of velocity and acceleration than otherwise.
        velocity_step = min(gains.velocity / usual, 1.0 / interval)
        steps = position_gain, velocity_step, min(acceleration_gain / usual**2, 1.0 / interval**2)
        corrected = [_corrected(state, off, steps) for state, off in zip(expected, error, strict=True)]
        self.states = self._bounded(corrected if moving else [(position, 0.0, 0.0) for position, _, _ in corrected])
        self.sample_ns = t_ns
        return gains.convergence

    def _usual_interval(self, interval_s: float) -> float:
        """The mean interval in s between samples, or this one, if it is shorter."""
        self._usual_s += (interval_s - self._usual_s) * (INTERVAL_MEMORY if self._usual_s else 1.0)
        return min(self._usual_s, interval_s)

    def at(self, t_ns: int) -> Numbers:
        """Compute where the target is at a time, by the newest sample."""
        return [position for position, *_ in Transition.over((t_ns - self.sample_ns) / NS_PER_S).of(self.states)]

    def _bounded(self, states: list[State]) -> list[State]:
        positions, wanted, _ = (list(column) for column in zip(*states, strict=True))
        velocities = self._clamp(positions, wanted)[1]
        return [
            (position, bounded, acceleration if bounded == velocity else 0.0)
            for (position, velocity, acceleration), bounded in zip(states, velocities, strict=True)
        ]


def _corrected(state: State, error: float, steps: State) -> State:
    (position, velocity, acceleration), (first, second, third) = state, steps
    return position + first * error, velocity + second * error, acceleration + third * error


class Haste:
    """The fraction of the joints' accelerations that the target needs, or has needed a moment ago.

    A slow motion goes on as it does, and is predicted. A quick one is an aim, and ends at once: predicted, its end is
    overshot, and by joints that are at the limit of their accelerations several times as far.
    """

    def __init__(self) -> None:
        self._needed = 0.0

    def update(self, needed: float, elapsed_s: float) -> None:
        """Note what the newest estimate needs."""
        self._needed = max(needed, self._needed * math.exp(-elapsed_s / HURRY_MEMORY_S))

    @property
    def calm(self) -> float:
        """From 1 for a slow motion to 0 for a hurried one."""
        return min(max((HURRIED - self._needed) / (HURRIED - CALM), 0.0), 1.0)

    def extrapolated(self, velocity: float, acceleration: float) -> tuple[float, float]:
        """The velocity and the acceleration with which a target is to go on."""
        calm = self.calm
        return (LEAST_EXTRAPOLATED + (1.0 - LEAST_EXTRAPOLATED) * calm) * velocity, calm * acceleration
