"""The path of the joints over the solutions of hand samples: a smooth curve, and what speed its bends allow; pure."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.motion.tool_shift import NOTHING, WRIST_ROLLS

PLANNED, BENT = 0.6, 0.7  # of the joints' accelerations: to brake ahead with, and for the bends themselves
SHORTEST_S = 1e-4  # nearer to each other, two solutions are one
COUNTED = 0.2  # of the speed of joints that roll the wrist, not of their acceleration: so much is waited for
AVERAGED_NS, AVERAGED_S = 100 * NS_PER_MS, 0.03  # of the hand's way and of the path, at most, against noise;
AVERAGED = 0.25  # or so much of the time that the path leads ahead, if that is longer
SOONEST_NS = 4 * NS_PER_MS  # between two solutions, for the hand's own speed


@dataclass(slots=True)
class Knot:
    """A place on the path, and the segment that ends there.

    The path is measured by `s`, the seconds that it takes at full speed: on it, the joint that needs most time for a
    segment moves at its greatest velocity, or 4 and 6 at several times that. `chord` (n,) is the segment's dq/ds in
    rad/s, `tangent` (n,) that in the place itself, `tool` how far the tool moves (m) and turns (rad) per s there,
    `own` the hand's own ds/dt. `gain` is the greatest d²s/dt² that is planned along the segment, `bend` the greatest
    (ds/dt)².
    """

    q: Array
    t_ns: int
    s: float
    chord: Array
    tangent: Array
    tool: tuple[float, float]
    own: float
    gain: float
    bend: float = math.inf


class JointPath:
    """Knots one after the other, each at a solution (n,) in rad and the time of its hand sample."""

    def __init__(self, model: ArmModel, limits: JointLimits) -> None:
        self._model = model
        self._velocity, self._acceleration = limits.velocity.copy(), limits.acceleration.copy()
        self._velocity[WRIST_ROLLS] /= COUNTED
        self.knots: deque[Knot] = deque()
        self._newest: deque[tuple[Array, int]] = deque()

    def clear(self) -> None:
        """No path."""
        self.knots.clear()
        self._newest.clear()

    def pace(self, dq: Array) -> float:
        """The ds/dt of joints that move with `dq` (n,) rad/s."""
        return float(np.max(np.abs(dq) / self._velocity))

    def begin(self, q: Array, t_ns: int, s: float, dq: Array, own: float) -> None:
        """Nothing but a place, passed with `dq` (n,) rad/s or in that direction."""
        pace = self.pace(dq)
        chord = dq / pace if pace > NOTHING else np.zeros(len(q))
        self.knots.clear()
        self.knots.append(self._knot(q, t_ns, s, chord, own))

    def add(self, q: Array, t_ns: int) -> None:
        """Lead on to `q`, unless the path knows a later place already.

        Noise bends the path, and bends are taken slowly. So a path that leads far ahead goes on to averages.
        """
        knots, last = self.knots, self.knots[-1]
        q, t_ns = self._averaged(q, t_ns)
        if t_ns <= last.t_ns:
            return
        knot = self.straight_on(q, t_ns)
        if knot.s < last.s + SHORTEST_S:
            last.t_ns = t_ns
            return
        knots.append(knot)
        if len(knots) > 2:
            before = knots[-3]
            former, latter = last.s - before.s, knot.s - last.s
            last.tangent = (last.chord * latter + knot.chord * former) / (former + latter)
            last.bend = self._bend(before, last)
        knot.bend = self._bend(last, knot)

    def _averaged(self, q: Array, t_ns: int) -> tuple[Array, int]:
        """The newest solutions' mean and its time, if the path leads far ahead of where the target is."""
        newest, knots = self._newest, self.knots
        newest.append((q, t_ns))
        ahead_ns = t_ns - knots[1].t_ns if len(knots) > 2 else 0
        window_ns = max(AVERAGED_NS, AVERAGED * ahead_ns)
        while t_ns - newest[0][1] > window_ns or self.pace(q - newest[0][0]) > AVERAGED_S:
            newest.popleft()
        if ahead_ns <= AVERAGED_NS:
            return q, t_ns
        return np.mean([place for place, _ in newest], axis=0), sum(at_ns for _, at_ns in newest) // len(newest)

    def straight_on(self, q: Array, t_ns: int) -> Knot:
        """A knot at `q` after the last one, not added."""
        last = self.knots[-1]
        step = q - last.q
        length = max(self.pace(step), NOTHING)
        return self._knot(
            q, t_ns, last.s + length, step / length, length * NS_PER_S / max(t_ns - last.t_ns, SOONEST_NS)
        )

    def gain(self, chord: Array) -> float:
        """The greatest d²s/dt² that is planned where dq/ds is `chord` (n,) rad/s."""
        return PLANNED * float(np.min(self._acceleration / np.maximum(np.abs(chord), NOTHING)))

    def _knot(self, q: Array, t_ns: int, s: float, chord: Array, own: float) -> Knot:
        twist = (self._model.jacobian(q) @ chord).tolist()
        tool = math.hypot(*twist[:3]), math.hypot(*twist[3:])
        return Knot(q, t_ns, s, chord, chord, tool, own, self.gain(chord))

    def _bend(self, begin: Knot, end: Knot) -> float:
        """The (ds/dt)² at which a segment's d²q/ds² takes their part of the accelerations.

        That of a cubic is greatest at an end.
        """
        length = end.s - begin.s
        at_begin = 6 * end.chord - 4 * begin.tangent - 2 * end.tangent
        at_end = 2 * begin.tangent + 4 * end.tangent - 6 * end.chord
        bent = float(np.max(np.maximum(np.abs(at_begin), np.abs(at_end)) / self._acceleration))
        return BENT * length / max(bent, NOTHING)


def part_of(begin: Knot, end: Knot, s: float) -> float:
    """Compute the fraction of a segment that is done at `s`."""
    return min(max((s - begin.s) / max(end.s - begin.s, NOTHING), 0.0), 1.0)


def on_the_curve(begin: Knot, end: Knot, s: float) -> tuple[Array, Array, Array]:
    """The joints (n,) in rad at `s` on a segment, with dq/ds and d²q/ds² (a cubic Hermite spline)."""
    x, length = part_of(begin, end, s), max(end.s - begin.s, NOTHING)
    way, out, into = end.q - begin.q, length * begin.tangent, length * end.tangent
    b, c = 3 * way - 2 * out - into, out + into - 2 * way
    q = begin.q + x * (out + x * (b + x * c))
    return q, (out + x * (2 * b + 3 * x * c)) / length, (2 * b + 6 * x * c) / length**2
