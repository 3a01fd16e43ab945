"""The path through setpoints, played at the robot's pace a fixed time after they were written; pure.

Setpoints are written as often as a process wakes, so the times at which they come say little about the time between
them; their own motion does. So each setpoint gets its place on the path from the one before it, and the times at which
they come only steer how fast the path is played: by up to 5 % more or less, and that changes slowly.
"""

from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_S
from common.geometry import Array
from remote_site.kinematics.joints import JointMotion

PLAIN_RAD_S = 0.005  # slower, the motion itself does not say how much time has passed
LONGEST_TICKS = 3.0  # between two setpoints in motion: one or two may be left out
SHORTEST_S = 1e-4
MOST_HASTE = 0.05
HASTE_S = 0.2  # in which a delay is made up
HASTE_PER_S = 1.0


@dataclass(frozen=True, slots=True)
class Knot:
    """A setpoint at a time of the path, s, and the number of its command."""

    at_s: float
    motion: JointMotion
    seq: int


class Segment:
    """The quintic between two knots: positions, velocities and accelerations of both are met."""

    def __init__(self, begin: Knot, end: Knot) -> None:
        T = end.at_s - begin.at_s
        a, b = begin.motion, end.motion
        step, v0, v1, a0, a1 = b.q - a.q, a.dq * T, b.dq * T, a.ddq * T * T, b.ddq * T * T
        self._T, self._begin_s = T, begin.at_s
        self._c = (
            a.q,
            v0,
            a0 / 2,
            10 * step - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
            -15 * step + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
            6 * step - 3 * (v0 + v1) + (a1 - a0) / 2,
        )

    def at(self, at_s: float) -> JointMotion:
        """The motion at a time of the path."""
        c0, c1, c2, c3, c4, c5 = self._c
        T, u = self._T, (at_s - self._begin_s) / self._T
        q = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
        dq = (c1 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / T
        ddq = (2 * c2 + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))) / (T * T)
        return JointMotion(q, dq, ddq)


class SetpointPath:
    """Begins at rest at `q` (n,) rad; setpoints come every `dt` s and are played `buffer_s` later.

    To be read: `seq`, the number of the setpoint that is gone to, None before the first; `starved`, once the path has
    ended in motion.
    """

    def __init__(self, q: Array, dt: float, buffer_s: float) -> None:
        self._dt, self._buffer_s = dt, buffer_s
        self._knots: deque[Knot] = deque([Knot(0.0, JointMotion.at_rest(q), 0)])
        self._segment: Segment | None = None
        self._written_ns = 0
        self._at_s, self._haste = 0.0, 0.0
        self.seq: int | None = None
        self.starved = False

    def add(self, motion: JointMotion, seq: int, t_ns: int) -> None:
        """Append a setpoint that was written at `t_ns`."""
        last = self._knots[-1]
        elapsed_s = (t_ns - self._written_ns) / NS_PER_S if self._written_ns else self._dt
        between_s = time_between(last.motion, motion, elapsed_s, self._dt)
        at_s = last.at_s + between_s
        if last.motion.resting:
            at_s = max(last.at_s + max(elapsed_s, between_s), self._at_s + self._buffer_s)
            if at_s - between_s > last.at_s:
                self._knots.append(Knot(at_s - between_s, last.motion, last.seq))
        self._knots.append(Knot(at_s, motion, seq))
        self._written_ns = t_ns

    def advance(self, dt: float, now_ns: int) -> JointMotion:
        """The motion `dt` s later."""
        self._steer(dt, now_ns)
        self._at_s += dt * (1 + self._haste)
        while len(self._knots) > 1 and self._knots[1].at_s <= self._at_s:
            self._knots.popleft()
            self._segment = None
        if len(self._knots) == 1:
            self.starved = not self._knots[0].motion.resting
            return self._knots[0].motion
        if self._segment is None:
            self._segment = Segment(self._knots[0], self._knots[1])
            self.seq = self._knots[1].seq or None
        motion, pace = self._segment.at(self._at_s), 1 + self._haste
        return JointMotion(motion.q, motion.dq * pace, motion.ddq * pace * pace)

    def late_s(self, now_ns: int) -> float:
        """By how much the path is played later than its setpoints were meant to be, s; 0 at rest."""
        newest = self._knots[-1]
        if newest.motion.resting:
            return 0.0
        return newest.at_s + (now_ns - self._written_ns) / NS_PER_S - self._buffer_s - self._at_s

    def _steer(self, dt: float, now_ns: int) -> None:
        wanted = min(max(self.late_s(now_ns) / HASTE_S, -MOST_HASTE), MOST_HASTE)
        self._haste += min(max(wanted - self._haste, -HASTE_PER_S * dt), HASTE_PER_S * dt)


def time_between(one: JointMotion, other: JointMotion, elapsed_s: float, dt: float) -> float:
    """The time in which one motion becomes the other, s, by their own speeds; where they are too slow, `elapsed_s`.

    Without a motion to tell it, a pause counts as one tick `dt`: the arm rested.
    """
    mean = (one.dq + other.dq) / 2
    weight = float(mean @ mean)
    between_s = min(elapsed_s, dt)
    if weight > PLAIN_RAD_S**2:
        curve, step = (other.ddq - one.ddq) / 12, other.q - one.q
        for _ in range(3):  # Simpson's rule, which is exact where the jerk is constant
            between_s = float(mean @ (step + curve * between_s**2)) / weight
            between_s = min(max(between_s, SHORTEST_S), max(LONGEST_TICKS * dt, elapsed_s))
    return max(between_s, SHORTEST_S)
