"""REPLACE, but keep for the tests: what the arm's own library offers, of an arm that exists only here."""

import math

import numpy as np
from numpy.typing import NDArray

from farhand.driver import Clock

LAG_S = 0.02


class SimulatedLibrary:
    """An arm that comes to where it was sent with a lag, and holds that; positions (n,) in rad."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._positions = self._goal = np.zeros(0)
        self._moved_ns = 0

    def connect(self, start: NDArray[np.float64]) -> None:
        """Be at `start`; a real arm is where it is."""
        self._positions = self._goal = start
        self._moved_ns = self._clock.now_ns()

    def measured_positions(self) -> NDArray[np.float64]:
        """Return where the joints are now."""
        now_ns = self._clock.now_ns()
        elapsed_s, self._moved_ns = (now_ns - self._moved_ns) / 1e9, now_ns
        self._positions = self._goal + (self._positions - self._goal) * math.exp(-elapsed_s / LAG_S)
        return self._positions

    def move_to(self, positions: NDArray[np.float64]) -> None:
        """Begin to go there."""
        self.measured_positions()
        self._goal = positions

    def hold(self) -> None:
        """Go no further."""
        self._goal = self.measured_positions()
