"""The figures of every pair of a track, for its plots and its table: 200 bytes a pair, 22 MB for an hour at 30 Hz."""

from array import array
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from common.messages.hand import TrackingStatus
from farhand.tracking.results.tracked_pair import TrackedPair
from farhand.tracking.summary import lasting_reason
from farhand.tracking.track_line import ALL_POINTS, POINTS

Mask = NDArray[np.bool_]  # (N,), one entry for each pair

STATUSES = tuple(TrackingStatus)
UNKNOWN = (float("nan"),) * 3
HEAD = 5
WIDTH = HEAD + 3 * len(ALL_POINTS) + len(POINTS)


class TrackHistory:
    """Rows of figures; every method that gives an array gives one entry (N) for each pair, NaN where unknown."""

    def __init__(self) -> None:
        self._rows = array("d")
        self._reasons: dict[str, int] = {}
        self.gripper_toggles = 0

    def add(self, pair: TrackedPair) -> None:
        """Keep the figures of a pair."""
        line = pair.line
        self.gripper_toggles = line.gripper_toggles
        reason = self._reasons.setdefault(lasting_reason(line), len(self._reasons))
        self._rows.extend((pair.t_s, STATUSES.index(line.status), reason, line.ms, _known(line.residual_px)))
        for name in ALL_POINTS:
            self._rows.extend(getattr(line, name) or UNKNOWN)
        self._rows.extend(_known(line.sigma[name]) for name in POINTS)

    def _columns(self, first: int, count: int = 1) -> Array:
        table = np.frombuffer(self._rows).reshape(-1, WIDTH)[:, first : first + count].copy()
        return table[:, 0] if count == 1 else table

    @property
    def pairs(self) -> int:
        """The number of pairs that were kept."""
        return len(self._rows) // WIDTH

    @property
    def t_s(self) -> Array:
        """The time of each pair since the first, s."""
        return self._columns(0)

    @property
    def ms(self) -> Array:
        """The time that each pair took, ms."""
        return self._columns(3)

    @property
    def residual_px(self) -> Array:
        """The rms epipolar residual between the views, px."""
        return self._columns(4)

    @property
    def measured_points(self) -> list[str]:
        """The names of the points that were found at least once."""
        return [name for name in ALL_POINTS if np.isfinite(self.position(name)).any()]

    def position(self, name: str) -> Array:
        """A point (N, 3), m."""
        return self._columns(HEAD + 3 * ALL_POINTS.index(name), 3)

    def speed(self, name: str) -> Array:
        """Compute how fast a point moved since the pair before, m/s."""
        steps = np.diff(self.position(name), axis=0), np.diff(self.t_s)
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = np.linalg.norm(steps[0], axis=1) / steps[1]
        return np.concatenate([[np.nan], np.where(np.isfinite(moved), moved, np.nan)])

    def sigma(self, name: str) -> Array:
        """The rms length of a point's error, m."""
        if name not in POINTS:
            return np.full(self.pairs, np.nan)
        return self._columns(HEAD + 3 * len(ALL_POINTS) + POINTS.index(name))

    def had(self, status: TrackingStatus) -> Mask:
        """Return which pairs had this status."""
        held: Mask = self._columns(1) == STATUSES.index(status)
        return held

    def reasons(self) -> list[tuple[str, Mask]]:
        """Each reason with whether each pair had it, the most frequent first; pairs without a reason are left out."""
        numbers = self._columns(2)
        names = list(self._reasons)
        counted = Counter(numbers.astype(int).tolist()).most_common()
        return [(names[k], numbers == k) for k, _ in counted if names[k]]


def _known(value: float | None) -> float:
    return np.nan if value is None else value
