"""How far the arm may still move before what was measured of distances leaves any doubt; pure."""

import math

from common.geometry import Array


class ClearanceCache:
    """Rooms in m that no joint uses up faster than its levers (m x n) in m per rad (or m) allow.

    Every joint's motion costs the greatest share that it may take of any room, so that their sum is never too low: one
    short sum, most ticks, instead of all rooms.
    """

    def __init__(self, levers: Array) -> None:
        self._levers = levers
        self._where = self._costs = [math.nan] * levers.shape[1]

    def note(self, q: list[float], rooms: Array) -> None:
        """The rooms (m,) left at joint positions (n,) in rad; where one is not positive, nothing is covered."""
        self._where = q
        if rooms.min(initial=math.inf) > 0.0:
            self._costs = (self._levers / rooms[:, None]).max(axis=0, initial=0.0).tolist()
        else:
            self._costs = [math.nan] * len(q)

    def covers(self, q: list[float], travel: list[float]) -> bool:
        """Whether every room outlasts the way to `q` (n,) and `travel` (n,) from there; never where one is NaN."""
        used = 0.0
        for cost, here, there, more in zip(self._costs, q, self._where, travel, strict=True):
            used += cost * (abs(here - there) + more)
        return used <= 1.0
