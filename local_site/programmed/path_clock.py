"""Where a run stands on its path: time that starts, stops and turns back smoothly; pure."""

import math

ACCELERATION_PER_S = 4.0  # of the path's time: a quarter of a second from rest to the path's own speed
NEAR_S = 1e-3
LEAST_RATE = 0.02  # the last way to a stop does not take for ever


class PathClock:
    """The path's time `t_s`, which goes on by `rate` seconds a second, below 0 backwards."""

    def __init__(self) -> None:
        self.t_s = self.rate = 0.0

    def begin(self, t_s: float) -> None:
        """Stand at a time of the path."""
        self.t_s, self.rate = t_s, 0.0

    def advance(self, elapsed_s: float, speed: float, stop_at_s: float | None) -> bool:
        """Go on for `elapsed_s` towards `stop_at_s`, at most `speed` times as fast as the path; whether it is there.

        Without a place to stop at, the path's time slows down and stands.
        """
        wanted = 0.0 if stop_at_s is None else self._towards(stop_at_s, speed)
        most = ACCELERATION_PER_S * elapsed_s
        self.rate += min(max(wanted - self.rate, -most), most)
        before_s, self.t_s = self.t_s, self.t_s + self.rate * elapsed_s
        if stop_at_s is None:
            return False
        passed = (before_s - stop_at_s) * (self.t_s - stop_at_s) <= 0.0
        if passed or abs(self.t_s - stop_at_s) < NEAR_S:
            self.t_s, self.rate = stop_at_s, 0.0
            return True
        return False

    def _towards(self, stop_at_s: float, speed: float) -> float:
        """The rate from which the time can still come to rest at `stop_at_s`."""
        left_s = stop_at_s - self.t_s
        return math.copysign(min(speed, max(math.sqrt(ACCELERATION_PER_S * abs(left_s)), LEAST_RATE)), left_s)
