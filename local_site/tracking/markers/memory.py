"""Where each marker was last seen, and where it should be now at constant velocity."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array

MAX_PREDICTION_NS = 200_000_000


@dataclass(frozen=True, slots=True)
class _Sighting:
    t_ns: int
    point: Array


class Memory:
    """The last two sightings of every marker; older ones than 0.2 s say nothing."""

    def __init__(self, markers: int = 3) -> None:
        self._sightings: list[list[_Sighting]] = [[] for _ in range(markers)]

    def keep(self, t_ns: int, points: Array) -> None:
        """Take the markers (N, 3) of an instant in m, NaN where one is not seen."""
        for sightings, point in zip(self._sightings, points, strict=True):
            if np.isfinite(point).all():
                sightings.append(_Sighting(t_ns, point))
                del sightings[:-2]

    def expected(self, t_ns: int) -> Array:
        """Where the markers should be (N, 3) in m, NaN for those of which nothing is known."""
        return np.array([_extrapolated(sightings, t_ns) for sightings in self._sightings])


def _extrapolated(sightings: list[_Sighting], t_ns: int) -> Array:
    if not sightings or not 0 < t_ns - sightings[-1].t_ns <= MAX_PREDICTION_NS:
        return np.full(3, np.nan)
    last = sightings[-1]
    if len(sightings) < 2 or last.t_ns - sightings[0].t_ns > MAX_PREDICTION_NS:
        return last.point
    before = sightings[0]
    return last.point + (t_ns - last.t_ns) / (last.t_ns - before.t_ns) * (last.point - before.point)
