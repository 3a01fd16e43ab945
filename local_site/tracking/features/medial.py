"""Medial lines of limbs: total least squares through the midpoints of the two edges (thesis 3.1.6, 3.1.7)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.kernels.pictures import grey_at
from local_site.tracking.features.silhouette import Silhouette

MIN_ROWS = 6
WIDTH_TOLERANCE = 1.4
EDGE_REACH = 3
STRIDE = 4  # px; nothing within a limb is darker than the level, so the way to its edge may be leapt along


@dataclass(frozen=True, slots=True)
class MedialLine:
    """A line in the image: a point on it (2,) in px and a unit direction (2,)."""

    point: Array
    direction: Array

    @property
    def normal(self) -> Array:
        """The unit normal (2,), the direction turned by +90 deg (x towards y)."""
        return np.array([-self.direction[1], self.direction[0]])

    @property
    def pair(self) -> tuple[Array, Array]:
        """Point and direction."""
        return self.point, self.direction

    def along(self, point: Array) -> float:
        """Signed distance in px of a pixel's foot from the line's point."""
        return float(self.direction @ (point - self.point))

    def at(self, distance: float) -> Array:
        """The pixel (2,) at a signed distance from the line's point."""
        result: Array = self.point + distance * self.direction
        return result


@dataclass(frozen=True, slots=True)
class Edges:
    """A limb's two edges on scan lines across an axis: at t (R,) px along it, offsets (R,) along its normal.

    Rows without an edge on both sides within the scan are NaN.
    """

    axis: MedialLine
    t: Array
    lower: Array
    upper: Array

    @property
    def rows(self) -> tuple[Array, Array, Array]:
        """Places along the axis and the offsets of both edges."""
        return self.t, self.lower, self.upper


def line_through(start: Array, end: Array) -> MedialLine | None:
    """The line from one pixel to another, or None where they coincide."""
    length = math.hypot(*(end - start))
    return MedialLine(start, (end - start) / length) if length > 1e-6 else None


def scan_edges(silhouette: Silhouette, axis: MedialLine, start: float, end: float, reach: float) -> Edges:
    """The edges of the limb around an axis, to a fraction of a pixel, on scan lines 1 px apart from start to end.

    Each scan line is followed from the axis to both sides until the grey value falls below the threshold.
    """
    first, rows = math.floor(start), max(math.ceil(end) + 1 - math.floor(start), 0)
    (x, y), (dx, dy) = axis.at(first).tolist(), axis.direction.tolist()
    t, lower, upper = _scan(silhouette.grey, silhouette.level, (x, y, dx, dy), rows, max(2, math.ceil(reach)))
    t += first
    return Edges(axis, t, lower, upper)


def limb_sides(silhouette: Silhouette, axis: MedialLine, start: float, end: float, reach: float) -> Array:
    """Typical offsets (2,) in px along an axis's normal of the limb's two edges between two places, the lower first.

    Each side stands for itself, NaN where most of it is not seen: beside a bent elbow only the arm's back has an edge.
    """
    (x, y), (dx, dy) = axis.at(start).tolist(), axis.direction.tolist()
    rows = max(math.ceil(end - start), 1)
    lower, upper = _sides(silhouette.grey, silhouette.level, (x, y, dx, dy), rows, max(2, math.ceil(reach)))
    return np.array([lower, upper])


@compiled
def _sides(
    grey: NDArray[np.uint8], level: float, axis: tuple[float, float, float, float], rows: int, reach: int
) -> tuple[float, float]:
    """The upper medians of where rows at 0, 1, ... px along an axis fall off on each side of it, NaN without most."""
    x, y, dx, dy = axis
    values, found = np.empty(reach + 1), np.empty(rows)
    typical = np.empty(2)
    for k, side in enumerate((-1.0, 1.0)):
        for row in range(rows):
            found[row] = _edge(grey, level, (x + row * dx, y + row * dy, -side * dy, side * dx), values)
        seen = np.sort(found[np.isfinite(found)])
        typical[k] = side * seen[len(seen) // 2] if 2 * len(seen) > rows else math.nan
    return typical[0], typical[1]


@compiled
def _scan(
    grey: NDArray[np.uint8], level: float, axis: tuple[float, float, float, float], rows: int, reach: int
) -> tuple[Array, Array, Array]:
    """Where rows at 0, 1, ... px along an axis fall off on both sides of it, px from there; NaN where one does not."""
    x, y, dx, dy = axis
    t, lower, upper = np.empty(rows), np.full(rows, np.nan), np.full(rows, np.nan)
    values = np.empty(reach + 1)
    for row in range(rows):
        t[row] = row
        before = _edge(grey, level, (x + row * dx, y + row * dy, dy, -dx), values)
        after = _edge(grey, level, (x + row * dx, y + row * dy, -dy, dx), values)
        if not (math.isnan(before) or math.isnan(after)):
            lower[row], upper[row] = -before, after
    return t, lower, upper


@compiled
def _edge(grey: NDArray[np.uint8], level: float, ray: tuple[float, float, float, float], values: Array) -> float:
    """Px along a ray (x, y and a unit step) to the edge: found where the values first drop below the level, placed
    where they fall most, which also holds for skin in shadow. `values` is room for those along the ray."""
    x, y, step_x, step_y = ray
    reach = len(values) - 1
    beyond = 0
    while beyond <= reach and grey_at(grey, x + beyond * step_x, y + beyond * step_y) > level:
        beyond += STRIDE
    last = min(beyond + EDGE_REACH, reach)
    for k in range(max(beyond - STRIDE - EDGE_REACH, 0), last + 1):
        values[k] = grey_at(grey, x + k * step_x, y + k * step_y)
    first = max(beyond - STRIDE, 0)
    while first <= reach and values[first] > level:
        first += 1
    if first == 0 or first > reach:
        return math.nan
    last = min(first + EDGE_REACH, reach)
    total, place = 0.0, 0.0
    for k in range(max(first - EDGE_REACH, 0), last):
        fall = values[k] - values[k + 1]
        if fall > 0:
            total += fall * fall
            place += fall * fall * (k + 0.5)
    return place / total if total > 0 else math.nan


def medial_line(edges: Edges, start: float, end: float) -> MedialLine | None:
    """The medial line of the limb between start and end along the scan axis, or None with too few clean rows.

    All P x R midpoints of upper and lower edge have the mean (a + b) / 2 and the covariance (Ca + Cb) / 4, so the line
    costs O(P + R); both edges cover the same rows, which keeps a taper from tilting it.
    """
    count, place, middle, along, across = _middle(*edges.rows, start, end)
    if count < MIN_ROWS:
        return None
    axis = edges.axis
    return MedialLine(axis.at(place) + middle * axis.normal, along * axis.direction + across * axis.normal)


@compiled
def _middle(t: Array, lower: Array, upper: Array, start: float, end: float) -> tuple[int, float, float, float, float]:
    """How many rows are clean, their mean along the scan axis and across, and the line's direction along and across."""
    typical = typical_width(t, lower, upper, start, end)
    count, a, u, v = 0, 0.0, 0.0, 0.0
    for k in range(len(t)):
        if start <= t[k] <= end and upper[k] - lower[k] < WIDTH_TOLERANCE * typical:
            count, a, u, v = count + 1, a + t[k], u + upper[k], v + lower[k]
    if count < MIN_ROWS:
        return count, 0.0, 0.0, 1.0, 0.0
    a, u, v = a / count, u / count, v / count
    tt, ts, ss = 0.0, 0.0, 0.0
    for k in range(len(t)):
        if start <= t[k] <= end and upper[k] - lower[k] < WIDTH_TOLERANCE * typical:
            along, up, low = t[k] - a, upper[k] - u, lower[k] - v
            tt, ts, ss = tt + along * along, ts + along * (up + low), ss + up * up + low * low
    angle = 0.5 * math.atan2(0.5 * ts, 0.5 * tt - 0.25 * ss)
    return count, a, 0.5 * (u + v), math.cos(angle), math.sin(angle)


@compiled
def typical_width(t: Array, lower: Array, upper: Array, start: float, end: float) -> float:
    """The upper median of the widths in px between two places along the scan axis, NaN where no row is clean."""
    widths, count = np.empty(len(t)), 0
    for k in range(len(t)):
        if start <= t[k] <= end and not math.isnan(lower[k]):
            widths[count] = upper[k] - lower[k]
            count += 1
    return float(np.sort(widths[:count])[count // 2]) if count else math.nan
