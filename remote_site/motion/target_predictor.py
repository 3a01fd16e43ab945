"""The predicted target between hand samples: each estimate joined to the one before without a jump; pure."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits, stoppable
from remote_site.kinematics.model import ArmModel
from remote_site.motion.catch_up import CatchUp
from remote_site.motion.config import ControlConfig
from remote_site.motion.estimator import Haste, State, TargetEstimator, Transition
from remote_site.motion.tool_sample import ToolSample

MADE_UP_NS = 40 * NS_PER_MS  # of a sample's age: to make up for more of it would overshoot wherever the hand turns
DELAY_MEMORY = 1 / 64  # weight of the newest sample in the delay, so that jitter hardly moves the target
NOTHING = 1e-18  # rad
SLOWEST = 0.01  # of full speed
TOOL_M_S2, TOOL_RAD_S2 = 4.0, 20.0  # an arm's tool can be accelerated as much, for targets that are the tool's
TOOL_M_S, TOOL_RAD_S = 1.0, 3.0  # and be as fast
SPEEDING = 2.0  # for a target faster than the arm may be: what it cannot follow is not predicted

Numbers = list[float]
Motion = tuple[Array, Array, Array]


@dataclass(frozen=True, slots=True)
class TargetCurve:
    """The curve to which the target converges at `rate` (rad/s) since `since_ns`; its `states` hold for `t_ns`."""

    states: list[State]
    t_ns: int
    since_ns: int
    rate: float


class Bounds(Protocol):
    """The bounds of a predicted target."""

    def clamp(self, q: Numbers, dq: Numbers) -> tuple[Numbers, Numbers]:
        """Position and velocity within the bounds."""

    def convergence(self, wanted: float, off: Numbers, dq_off: Numbers) -> float:
        """The convergence rate in rad/s, `wanted` or slower, for what position and velocity have to lose."""

    def tool_speed(self, q: Numbers, dq: Numbers) -> tuple[float, float]:
        """Compute how fast the tool moves (m/s) and turns (rad/s) when the target is at `q` and moves with `dq`."""

    def effort(self, dq: Numbers, ddq: Numbers, speed: float) -> float:
        """The fraction of the greatest accelerations that these are, or more for an arm slowed to the fraction `speed`.

        There a target counts for as much as it is faster than the arm may be: the arm falls behind.
        """


class Unbounded:
    """No bounds, as for the pose of the tool: a position in m and a turn in rad."""

    def clamp(self, q: Numbers, dq: Numbers) -> tuple[Numbers, Numbers]:
        """The same."""
        return q, dq

    def convergence(self, wanted: float, off: Numbers, dq_off: Numbers) -> float:  # noqa: ARG002  # the protocol's
        """The wanted rate."""
        return wanted

    def tool_speed(self, q: Numbers, dq: Numbers) -> tuple[float, float]:  # noqa: ARG002  # the protocol's
        """The target is the tool's."""
        return math.hypot(*dq[:3]), math.hypot(*dq[3:])

    def effort(self, dq: Numbers, ddq: Numbers, speed: float) -> float:
        """Of what most arms can."""
        accelerated = max(math.hypot(*ddq[:3]) / TOOL_M_S2, math.hypot(*ddq[3:]) / TOOL_RAD_S2)
        moved = max(math.hypot(*dq[:3]) / TOOL_M_S, math.hypot(*dq[3:]) / TOOL_RAD_S)
        return max(accelerated, SPEEDING * (moved / speed - 1.0))


class JointBounds:
    """Joints (n,) in rad stay where they can stop inside their limits, and converge within their acceleration."""

    def __init__(self, model: ArmModel, limits: JointLimits, slowest: float) -> None:
        self._model = model
        fastest = TARGET_SPEED * limits.velocity
        # Further than this from its limits, a joint can stop from any speed.
        far = (fastest**2 / limits.acceleration + fastest * limits.acceleration / limits.jerk) / 2
        columns = limits.lower, limits.lower + far, limits.upper - far, limits.upper, fastest
        dynamics = limits.acceleration, limits.jerk
        self._joints = list(zip(*(column.tolist() for column in (*columns, *dynamics)), strict=True))
        self._velocity, self._acceleration = limits.velocity.tolist(), limits.acceleration.tolist()
        self._slowest = slowest

    def convergence(self, wanted: float, off: Numbers, dq_off: Numbers) -> float:
        """The rate that every joint can follow: one that cannot would lag and take the tool off the common path."""
        rate = wanted
        for away, step, most in zip(map(abs, off), map(abs, dq_off), self._acceleration, strict=True):
            if rate * (rate * away + 2 * step) > most:  # the acceleration at the start, at worst
                rate = (math.sqrt(step * step + most * away) - step) / away if away > NOTHING else most / (2 * step)
        return max(rate, self._slowest)

    def tool_speed(self, q: Numbers, dq: Numbers) -> tuple[float, float]:
        """By the arm's Jacobian."""
        twist = (self._model.jacobian(np.array(q)) @ np.array(dq)).tolist()
        return math.hypot(*twist[:3]), math.hypot(*twist[3:])

    def effort(self, dq: Numbers, ddq: Numbers, speed: float) -> float:
        """Of the joint that needs most of its own."""
        accelerated = max(abs(needed) / most for needed, most in zip(ddq, self._acceleration, strict=True))
        moved = max(abs(needed) / most for needed, most in zip(dq, self._velocity, strict=True))
        return float(max(accelerated, SPEEDING * (moved / speed - 1.0)))

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

    The estimate of each sample (`estimator.py`) is extrapolated for at most `predict_ms` after the sample arrived; for
    0 not at all. The target converges to every new curve, critically damped and without a jump of position or velocity.
    It follows a steady motion without lag while samples are no older than MADE_UP_NS when they arrive, and otherwise by
    the rest of their age behind; a hurried one (`Haste`) up to 100 ms behind, so that its end is not overshot.

    A target that had come to rest, at a reset or because samples were late, catches up with its curve no faster than
    `catch_up.py` allows.
    """

    def __init__(self, size: int, config: ControlConfig, bounds: Bounds | None = None) -> None:
        self._predict_ns = round(config.predict_ms * NS_PER_MS)
        self._bounds = bounds or Unbounded()
        self._estimator = TargetEstimator(config, self._bounds.clamp)
        self._catch_up = CatchUp(self._predict_ns, self._bounds.tool_speed)
        self.reset(0, np.zeros(size))

    @property
    def delay_ns(self) -> int:
        """The time since the hand was where the target is, ns."""
        return self._delay_ns

    def reset(self, t_ns: int, q: Array) -> None:
        """A target that rests at `q` (n,) since `t_ns`."""
        self._haste = Haste()
        self._end_ns = t_ns
        self._delay_ns, self._is_first = 0, True
        self._estimator.reset(t_ns, q.tolist())
        self._curve = TargetCurve(self._estimator.states, t_ns, t_ns, self._estimator.rate_at_rest)
        # of every number: its offset from the curve, the offset's initial decay, what it has to catch up with slowly
        self._offsets = [(0.0, 0.0, 0.0) for _ in q]
        self._catch_up.reset(t_ns, self._curve.rate)

    def aim(self, sample: ToolSample, q: Array, *, moving: bool = True) -> None:
        """Take a new sample of the target, (n,) numbers `q` for the time `sample.t_ns`, later than the last.

        A target that moves only because it is held near the arm (not `moving`) is not extrapolated.
        """
        t_ns, now_ns = sample.t_ns, sample.now_ns
        if t_ns <= self._estimator.sample_ns:
            return
        self._catch_up.limit_speed(sample.spare)
        self.note_arrival(sample)
        ended = t_ns > self._end_ns - self._delay_ns
        rested, settled = self._at_end() if ended else None, self._catch_up.learning == 0
        elapsed_s = (t_ns - self._estimator.sample_ns) / NS_PER_S
        rate = self._estimator.update(t_ns, q, rested, moving=moving, settled=settled)
        _, dq, ddq = (list(column) for column in zip(*self._estimator.states, strict=True))
        self._haste.update(self._bounds.effort(dq, ddq, max(sample.speed, SLOWEST)), elapsed_s)
        self._learn_delay(now_ns - t_ns)
        self._end_ns = self._catch_up.due_ns if self._predict_ns else t_ns + self._delay_ns
        curve = [(at, *self._haste.extrapolated(*motion)) for at, *motion in self._estimator.states]
        self._turn_to(t_ns + self._delay_ns, curve, now_ns, rate)

    def note_arrival(self, sample: ToolSample) -> None:
        """Note that a sample has come, late or not; also one that gives no target."""
        self._catch_up.note_arrival(sample.now_ns, sample.stretch)

    def at(self, now_ns: int) -> Motion:
        """The target's position (n,), velocity and acceleration (n,) per s and s² at `now_ns`, within its bounds."""
        if now_ns > self._end_ns and any(velocity for _, velocity, _ in self._curve.states):
            rest = [(position, 0.0, 0.0) for position in self._at_end()]
            self._turn_to(self._end_ns, rest, self._end_ns, self._curve.rate)
        positions, wanted, accelerations = self._converging(now_ns)
        positions, velocities = self._bounds.clamp(positions, wanted)
        columns = zip(accelerations, velocities, wanted, strict=True)
        bounded = [acceleration if velocity == free else 0.0 for acceleration, velocity, free in columns]
        return np.array(positions), np.array(velocities), np.array(bounded)

    def _learn_delay(self, age_ns: int) -> None:
        """Learn how much older the samples are than what is made up for."""
        older_ns = max(age_ns - MADE_UP_NS, 0)
        self._delay_ns += older_ns if self._is_first else round(DELAY_MEMORY * (older_ns - self._delay_ns))
        self._is_first = False

    def _at_end(self) -> Numbers:
        """Compute where the extrapolation ends."""
        return self._estimator.at(self._end_ns - self._delay_ns)

    def _turn_to(self, t_ns: int, states: list[State], now_ns: int, rate: float) -> None:
        """Take a new curve, whose states hold for `t_ns`, from `now_ns`; the target's offset from it decays."""
        since = (now_ns - t_ns) / NS_PER_S
        here, moving, _ = self._converging(now_ns)
        now = Transition.over(since).of(states)
        off = [at - position for at, (position, _, _) in zip(here, now, strict=True)]
        dq_off = [at - velocity for at, (_, velocity, _) in zip(moving, now, strict=True)]
        rate = self._bounds.convergence(rate, off, dq_off)
        remaining = self._catch_up.remaining([late for *_, late in self._offsets], now_ns - self._curve.since_ns)
        slow = self._catch_up.update_slow_part(here, off, dq_off, rate, remaining)
        slow_rate, columns = self._catch_up.rate, zip(off, dq_off, slow, strict=True)
        self._offsets = [
            (away - late, step + slow_rate * late + rate * (away - late), late) for away, step, late in columns
        ]
        self._curve = TargetCurve(states, t_ns, now_ns, rate)

    def _converging(self, now_ns: int) -> tuple[Numbers, Numbers, Numbers]:
        curve, rate = self._curve, self._curve.rate
        t, since = (now_ns - curve.t_ns) / NS_PER_S, max(now_ns - curve.since_ns, 0) / NS_PER_S
        slow_rate = self._catch_up.rate
        decay, slow_decay = math.exp(-rate * since), math.exp(-slow_rate * since)
        positions, velocities, accelerations = [], [], []
        _, way, gained, fading = Transition.over(t)
        for (position, velocity, acceleration), (off, push, late) in zip(curve.states, self._offsets, strict=True):
            left, lacking, pushed = decay * (off + since * push), slow_decay * late, decay * push
            positions.append(position + t * velocity + way * acceleration + left + lacking)
            velocities.append(velocity + gained * acceleration + pushed - rate * left - slow_rate * lacking)
            decaying = rate * (rate * left - 2 * pushed) + slow_rate * slow_rate * lacking
            accelerations.append(fading * acceleration + decaying)
        return positions, velocities, accelerations


def joint_target_predictor(model: ArmModel, limits: JointLimits, config: ControlConfig) -> TargetPredictor:
    """The predictor of a joint target (n,) in rad, kept where the joints can stop inside their limits."""
    return TargetPredictor(len(limits.names), config, JointBounds(model, limits, config.glide_rad_s))
