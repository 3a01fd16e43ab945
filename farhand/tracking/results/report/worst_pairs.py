"""The pairs of a track that a person should look at: the worst, and one for each reason; kept as PNG while it runs."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from farhand.tracking.results.tracked_pair import TrackedPair
from farhand.tracking.summary import lasting_reason
from farhand.tracking.track_line import ALL_POINTS, POINTS, TrackLine
from local_site.tracking.tracker import extrapolation

WORST, REASONS = 10, 10
APART_S = 0.2


@dataclass(frozen=True, slots=True)
class PairDoubt:
    """The distance by which a point may be off, m, and in words which point and why."""

    metres: float
    words: str


@dataclass(frozen=True, slots=True)
class ShownPair:
    """A pair with its picture (PNG), and why it is shown."""

    frame: int
    t_s: float
    why: str
    doubt: PairDoubt | None
    png: bytes


class WorstPairs:
    """The ten pairs of the greatest doubt, at most one in each fifth of a second, and the first of each reason.

    The doubt is the greatest, over the pair's points, of sigma and of the jump: the distance from where the straight
    line through the two pairs before would have led. A pair without a point has none.
    """

    def __init__(self) -> None:
        self._by_time: dict[int, ShownPair] = {}
        self._by_reason: dict[str, ShownPair] = {}
        self._before: deque[TrackLine] = deque(maxlen=2)

    def add(self, pair: TrackedPair) -> None:
        """Keep the picture of a pair if it belongs to those shown so far."""
        doubt = max(_doubts(pair.line, self._before), key=lambda found: found.metres, default=None)
        self._before.append(pair.line)
        if doubt is not None:
            self._keep(pair, doubt)
        reason = lasting_reason(pair.line)
        if reason and reason not in self._by_reason and len(self._by_reason) < REASONS:
            self._by_reason[reason] = _shown(pair, doubt, f"{pair.line.status.value}: {reason}")

    def _keep(self, pair: TrackedPair, doubt: PairDoubt) -> None:
        kept, when = self._by_time, int(pair.t_s / APART_S)
        rival = when if when in kept else min(kept, key=lambda k: _metres(kept[k])) if len(kept) == WORST else None
        if rival is None or doubt.metres > _metres(kept[rival]):
            if rival is not None:
                del kept[rival]
            kept[when] = _shown(pair, doubt, doubt.words)

    @property
    def worst(self) -> list[ShownPair]:
        """The pairs of the greatest doubt, the greatest first."""
        return sorted(self._by_time.values(), key=_metres, reverse=True)

    @property
    def first_of_reason(self) -> list[ShownPair]:
        """The first pair of each reason, in the order of time."""
        return list(self._by_reason.values())


def _doubts(line: TrackLine, before: deque[TrackLine]) -> Iterator[PairDoubt]:
    for name in POINTS:
        if (sigma := line.sigma[name]) is not None:
            yield PairDoubt(sigma, f"{name}: sigma {1e3 * sigma:.1f} mm")
    for name in ALL_POINTS:
        if (jump := _jump(name, line, before)) is not None:
            yield PairDoubt(jump, f"{name}: a jump of {1e3 * jump:.1f} mm")


def _jump(name: str, line: TrackLine, before: deque[TrackLine]) -> float | None:
    """The distance of a point from the straight line's end, m; None without two pairs shortly before."""
    places = [getattr(known, name) for known in (*before, line)]
    if len(places) < 3 or None in places:
        return None
    times_ns = [known.t_ns for known in (*before, line)]
    ahead = extrapolation(times_ns[2], times_ns[1], times_ns[0])
    first, last, now = np.array(places)
    return float(np.linalg.norm(now - last - ahead * (last - first))) if ahead else None


def _metres(shown: ShownPair) -> float:
    return shown.doubt.metres if shown.doubt else 0.0


def _shown(pair: TrackedPair, doubt: PairDoubt | None, why: str) -> ShownPair:
    png = cv2.imencode(".png", pair.picture)[1].tobytes()
    return ShownPair(pair.line.frame, pair.t_s, why, doubt, png)
