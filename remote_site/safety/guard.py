"""The last gate before the driver, without an off switch: what passes can always be stopped inside every limit."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.clearance import ClearanceCheck
from remote_site.safety.stopping import JointState, Span, span, stopping, stops

RELATIVE = 1e-6  # of a limit: what rounding may add to velocity, acceleration and jerk
POSITION = 1e-9  # rad and m: what rounding may add to a position


@dataclass(frozen=True, slots=True)
class Passed:
    """The motion may be sent."""

    motion: JointMotion


@dataclass(frozen=True, slots=True)
class Refused:
    """The motion must not be sent, and why; the stop from the last sent motion may."""

    reason: Reason


class JointGuard:
    """Judges each proposed motion against the one really sent before it, one tick of `dt` seconds ago.

    Always: finite; velocity (also the one that remains when the acceleration is taken back), acceleration and jerk
    within limits; position, velocity and acceleration consistent with a jerk within limits during the tick; and its
    stop ends within the position limits, or at least no further outside than the last motion's would. So the stop from
    the last motion always passes, and an arm outside can retreat.
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        self.limits = limits
        self.dt = dt
        # With |jerk| <= J the trapezoidal rule is off by at most J dt²/4 in velocity and J dt³/12 in position.
        tick = (limits.jerk * dt, limits.jerk * dt**2 / 4, limits.jerk * dt**3 / 12)
        columns = (limits.velocity, limits.acceleration, limits.jerk, *tick)
        self._bounds = list(zip(*((column * (1 + RELATIVE)).tolist() for column in columns), strict=True))
        self._most = list(zip(limits.acceleration.tolist(), limits.jerk.tolist(), strict=True))
        self._range = list(zip(limits.lower.tolist(), limits.upper.tolist(), strict=True))

    def check(self, proposed: JointMotion, sent: JointMotion) -> Passed | Refused:
        """Passed, or Refused with the first rule that was broken."""
        if not (proposed.finite and sent.finite):
            return Refused(reason(Code.NOT_FINITE, what="command"))
        return self.check_finite(proposed, sent, self.spans(proposed))

    def check_finite(self, proposed: JointMotion, sent: JointMotion, spans: list[Span]) -> Passed | Refused:
        """The same for finite motions; `spans` bound the proposed one's path to rest."""
        broken = self._dynamics(proposed, sent)
        if broken is None:
            broken = self._position(proposed, sent, spans)
        return Passed(proposed) if broken is None else Refused(broken)

    def spans(self, motion: JointMotion) -> list[Span]:
        """Bounds of every joint's path to rest: a middle and a reach in rad."""
        return [span(state, *most) for state, most in zip(_states(motion), self._most, strict=True)]

    def stop(self, sent: JointMotion) -> JointMotion:
        """The motion one tick into the stop from what was really sent; it always passes."""
        return stopping(sent, self.limits, self.dt)

    def is_stop(self, proposed: JointMotion, sent: JointMotion) -> bool:
        """Return whether a motion is the stop from the one before it."""
        return self.same(proposed, self.stop(sent))

    def same(self, one: JointMotion, other: JointMotion) -> bool:
        """Return whether two motions differ by rounding only."""
        return bool(
            np.abs(one.q - other.q).max() <= POSITION
            and np.abs(one.dq - other.dq).max() <= POSITION / self.dt
            and np.abs(one.ddq - other.ddq).max() <= POSITION / self.dt**2
        )

    def _dynamics(self, proposed: JointMotion, sent: JointMotion) -> Reason | None:
        half = self.dt / 2
        for i, (new, old, bounds) in enumerate(zip(_states(proposed), _states(sent), self._bounds, strict=True)):
            (q, v, a), (q0, v0, a0) = new, old
            velocity, acceleration, jerk, step, velocity_off, position_off = bounds
            speed = max(abs(v), abs(v + a * abs(a) / (2 * jerk)))
            if not speed <= velocity:
                return self._over(Code.VELOCITY, i, speed, self.limits.velocity)
            if not -acceleration <= a <= acceleration:
                return self._over(Code.ACCELERATION, i, abs(a), self.limits.acceleration)
            if not -step <= a - a0 <= step:
                return self._over(Code.JERK, i, abs(a - a0) / self.dt, self.limits.jerk)
            if (
                abs(v - v0 - half * (a + a0)) > velocity_off + POSITION
                or abs(q - q0 - half * (v + v0)) > position_off + POSITION
            ):
                return reason(Code.INCONSISTENT, joint=self.limits.names[i])
        return None

    def _position(self, proposed: JointMotion, sent: JointMotion, spans: list[Span]) -> Reason | None:
        for i, ((middle, reach), (lower, upper)) in enumerate(zip(spans, self._range, strict=True)):
            if lower + reach <= middle <= upper - reach:
                continue  # so it rests inside
            low, high = self._extent(proposed, i)
            excess = max(lower - low, high - upper)
            if excess > POSITION and excess > self._excess(sent, i) + POSITION:
                value = low if low < lower else high
                return reason(Code.POSITION, joint=self.limits.names[i], value=value, lower=lower, upper=upper)
        return None

    def _excess(self, motion: JointMotion, joint: int) -> float:
        """Compute how far outside its limits a joint gets on its path to rest, rad; negative inside."""
        low, high = self._extent(motion, joint)
        lower, upper = self._range[joint]
        excess: float = max(lower - low, high - upper)
        return excess

    def _extent(self, motion: JointMotion, joint: int) -> tuple[float, float]:
        return stops(motion, self.limits)[joint].extent()

    def _over(self, code: Code, joint: int, value: float, limits: Array) -> Reason:
        return reason(code, joint=self.limits.names[joint], value=value, limit=limits[joint])


class Guard:
    """The joints' guard and the clearance check: on the path to rest the tool stays in its box, and every pair of
    bodies keeps the margin; an arm that is not clear may only retreat.
    """

    def __init__(self, limits: JointLimits, clearance: ClearanceCheck, dt: float) -> None:
        self._joints = JointGuard(limits, dt)
        self._clearance = clearance

    def check(self, proposed: JointMotion, sent: JointMotion) -> Passed | Refused:
        """Passed, or Refused with the first rule that was broken."""
        if not (proposed.finite and sent.finite):
            return Refused(reason(Code.NOT_FINITE, what="command"))
        spans = self._joints.spans(proposed)
        verdict = self._joints.check_finite(proposed, sent, spans)
        if isinstance(verdict, Refused):
            return verdict
        doubtful = self._clearance.in_doubt([middle for middle, _ in spans], [reach for _, reach in spans])
        if not len(doubtful):
            return verdict
        ends = stops(proposed, self._joints.limits)
        if self._clearance.clear(ends, doubtful) or self._joints.is_stop(proposed, sent):
            return verdict
        if self._clearance.retreats(ends, sent.q):
            return verdict
        return Refused(self._clearance.why(proposed, ends))

    def stop(self, sent: JointMotion) -> JointMotion:
        """The motion one tick into the stop from what was really sent; it always passes."""
        return self._joints.stop(sent)


def _states(motion: JointMotion) -> Iterator[JointState]:
    return zip(motion.q.tolist(), motion.dq.tolist(), motion.ddq.tolist(), strict=True)
