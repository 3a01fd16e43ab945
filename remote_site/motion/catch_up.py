"""Catch-up with a target that the tool was left behind: its speed beyond the target's own motion; pure."""

import math
from collections.abc import Callable

from common.clock import NS_PER_S

Numbers = list[float]

CATCH_UP_M_S, CATCH_UP_RAD_S = 0.045, math.radians(13.5)  # a tenth is left for the overshoot of estimated speeds
BOUNDS = CATCH_UP_M_S, CATCH_UP_RAD_S
LEARNING = 6  # samples after a rest: so long a change of the estimate is no news of the hand, but what was left behind


def slower_rate(rate: float, drift: tuple[float, float], spare: float) -> float:
    """The rate in rad/s, `rate` or less, with which the slower part of an offset decays.

    An offset x from a moving line that decays with the rates s < r as x = a exp(-s t) + b exp(-r t) has
    a = (r x0 + dx0) / (r - s). Its first part is the motion beyond the line's, at s |a| at most; the second takes the
    speed from that of before. So s = r v / (|r x0 + dx0| + v) keeps to the speed v. `drift` is |r x0 + dx0| of the tool
    in m/s and rad/s; of v only the fraction `spare` is left. Critical damping will do from half of v on.
    """
    slower = rate
    for amount, bound in zip(drift, BOUNDS, strict=True):
        if amount > bound * spare / 2:
            slower = min(slower, rate * bound * spare / (amount + bound * spare))
    return slower


def decay_rate(rate: float, late: tuple[float, float], spare: float) -> float:
    """The rate in rad/s, `rate` or less, with which what the tool lacks (m and rad) may decay."""
    return min(rate, *(bound * spare / amount for amount, bound in zip(late, BOUNDS, strict=True) if amount > 0))


class CatchUp:
    """The part of a target's offset from its curve that decays slowly, since a rest has left it behind.

    `rate` is that of its decay in rad/s, `learning` how many samples more tell only what was left behind. `tool_speed`
    gives how fast the tool moves (m/s) and turns (rad/s) where the target is at a place and moves with a velocity.
    """

    def __init__(self, predict_ns: int, tool_speed: Callable[[Numbers, Numbers], tuple[float, float]]) -> None:
        self._predict_ns, self._tool_speed = predict_ns, tool_speed

    def reset(self, t_ns: int, rate: float) -> None:
        """The target rests since `t_ns`."""
        self.rate, self.due_ns = rate, t_ns
        self.learning, self._spare = LEARNING, 1.0

    def note_arrival(self, now_ns: int, stretch: float) -> None:
        """Note that a sample has come: late, if after `due_ns`, which is then set for the next one."""
        late = now_ns > self.due_ns and self._predict_ns > 0
        self.learning = LEARNING if late else max(self.learning - 1, 0)
        self.due_ns = now_ns + round(stretch * self._predict_ns)

    def limit_speed(self, spare: float) -> None:
        """Keep to this fraction of the catch-up speed from now on."""
        self._spare = spare

    def remaining(self, late: Numbers, since_ns: int) -> Numbers:
        """Compute what is left of a slow part after a time."""
        decay = math.exp(-self.rate * max(since_ns, 0) / NS_PER_S)
        return [amount * decay for amount in late]

    def update_slow_part(self, here: Numbers, off: Numbers, dq_off: Numbers, rate: float, late: Numbers) -> Numbers:
        """Return the slow part of a new offset from a line, which otherwise decays with `rate`; set its own rate.

        `late` is what is left of the slow part so far.
        """
        if self.learning:
            drift = [rate * away + step for away, step in zip(off, dq_off, strict=True)]
            self.rate = slower_rate(rate, self._tool_speed(here, drift), self._spare)
            return [amount / (rate - self.rate) if self.rate < rate else 0.0 for amount in drift]
        if not any(late):
            return late
        self.rate = decay_rate(rate, self._tool_speed(here, late), self._spare)
        return late if self.rate < rate else [0.0] * len(late)
