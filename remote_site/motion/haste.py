"""Haste of a target's motion, and how much of it is therefore extrapolated; pure."""

import math

Numbers = list[float]

CALM, HURRIED = 0.15, 0.4  # of the joints' accelerations: full prediction below, the least above
MEMORY_S = 0.3  # how long a hurry is remembered: between its two accelerations a movement has none
LEAST = 0.3  # of the velocity that is extrapolated in a hurry


class Haste:
    """The fraction of the joints' accelerations that the target needs, or has needed a moment ago.

    A slow motion goes on as it does, and is predicted. A quick one is an aim, and ends at once: predicted, its end is
    overshot, and by joints that are at the limit of their accelerations several times as far.
    """

    def __init__(self) -> None:
        self._needed = 0.0

    def update(self, needed: float, elapsed_s: float) -> None:
        """Note what the newest estimate needs."""
        self._needed = max(needed, self._needed * math.exp(-elapsed_s / MEMORY_S))

    @property
    def calm(self) -> float:
        """From 1 for a slow motion to 0 for a hurried one."""
        return min(max((HURRIED - self._needed) / (HURRIED - CALM), 0.0), 1.0)

    def extrapolated(self, velocity: float, acceleration: float) -> tuple[float, float]:
        """The velocity and the acceleration with which a target is to go on."""
        calm = self.calm
        return (LEAST + (1.0 - LEAST) * calm) * velocity, calm * acceleration
