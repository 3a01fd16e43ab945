"""Knowledge of a marked hand: distances and sizes of its markers, when it counts as open, the last positions."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.markers.identity import INDEX, ROLES, SPANS, THUMB, WRIST, Spans
from local_site.tracking.tracker import MAX_PREDICTION_NS, extrapolation

MAX_SPREAD = 0.08


@dataclass(frozen=True, slots=True)
class MarkedHand:
    """The learned distances, and the markers' diameters (3,) in m: wrist, index, thumb."""

    spans: Spans
    sizes: Array


class Learning:
    """Takes medians over the first instants that show all markers of a hand that keeps its shape."""

    def __init__(self, wanted: int) -> None:
        self._lengths = deque[Array](maxlen=wanted)
        self._sizes = deque[Array](maxlen=wanted)

    @property
    def count(self) -> int:
        """Return how many instants it has."""
        return len(self._lengths)

    def learn(self, points: Array, sizes: Array) -> MarkedHand | None:
        """Take the markers (3, 3) of one instant in m, and their diameters (3,) in m.

        Returns the hand, once there are enough instants and it has held still in its shape.
        """
        self._lengths.append(span_lengths(points))
        self._sizes.append(sizes)
        lengths = np.array(self._lengths)
        if len(lengths) < (self._lengths.maxlen or 1):
            return None
        middle = np.median(lengths, axis=0)
        if np.any(np.ptp(lengths, axis=0) > MAX_SPREAD * middle):
            return None
        wrist_index, wrist_thumb, index_thumb = (float(value) for value in middle)
        return MarkedHand(Spans((wrist_index, wrist_thumb, index_thumb)), np.median(np.array(self._sizes), axis=0))


def span_lengths(points: Array) -> Array:
    """The distances (3,) wrist to index, wrist to thumb, index to thumb of points (3, 3), NaN where one is missing."""
    return np.array([np.linalg.norm(points[a] - points[b]) for a, b in SPANS])


def is_open(points: Array, spans: Spans, open_ratio: float, was_open: bool) -> bool:
    """Return whether the markers (3, 3) are those of an open hand; where index or thumb is missing, as it was.

    When the fingers spread, the thumb goes away from the index and nearer to the radial side of the wrist. So the
    ratio of its distances from both is compared with the learned one, with hysteresis.
    """
    if not np.isfinite(points[[WRIST, INDEX, THUMB]]).all():
        return was_open
    _, wrist_thumb, index_thumb = span_lengths(points)
    _, learned_wrist_thumb, learned_index_thumb = spans.lengths
    ratio = float(index_thumb / max(wrist_thumb, 1e-9)) * learned_wrist_thumb / learned_index_thumb
    return ratio > (0.5 * (1.0 + open_ratio) if was_open else open_ratio)


class Memory:
    """The last two positions of every marker, and their extrapolation at constant velocity for up to 0.2 s."""

    def __init__(self) -> None:
        self._seen: list[list[tuple[int, Array]]] = [[] for _ in ROLES]

    def keep(self, t_ns: int, points: Array) -> None:
        """Take the markers (3, 3) of an instant in m, NaN where one is not seen."""
        for seen, point in zip(self._seen, points, strict=True):
            if np.isfinite(point).all():
                seen.append((t_ns, point))
                del seen[:-2]

    def expected(self, t_ns: int) -> Array:
        """The expected positions (3, 3) of the markers in m, NaN for those that were not seen recently."""
        expected = np.full((len(ROLES), 3), np.nan)
        for role, seen in enumerate(self._seen):
            if seen and 0 < t_ns - seen[-1][0] <= MAX_PREDICTION_NS:
                (before_ns, before), (last_ns, last) = seen[0], seen[-1]
                expected[role] = last + extrapolation(t_ns, last_ns, before_ns) * (last - before)
        return expected
