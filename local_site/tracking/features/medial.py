"""A limb's edges, and its medial line: total least squares through their midpoints (thesis 3.1.6, 3.1.7)."""

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
STRIDE = 4  # px; nothing within a limb is darker than the level, so its edge may be searched for in strides


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
        """Positions along the axis and the offsets of both edges."""
        return self.t, self.lower, self.upper

    def widest(self, start: float, end: float) -> float:
        """The largest width in px between two positions along the axis, NaN if no row is clean."""
        inside = (self.t > start) & (self.t < end)
        return float(np.fmax.reduce(self.upper[inside] - self.lower[inside], initial=np.nan))


def line_through(start: Array, end: Array) -> MedialLine | None:
    """The line from one pixel to another, or None if they coincide."""
    length = math.hypot(*(end - start))
    return MedialLine(start, (end - start) / length) if length > 1e-6 else None


def scan_edges(silhouette: Silhouette, axis: MedialLine, start: float, end: float, reach: float) -> Edges:
    """The edges of the limb around an axis, with subpixel precision, on scan lines 1 px apart from start to end.

    Each scan line is followed from the axis to both sides until the grey value falls below the threshold.
    """
    first, rows = math.floor(start), max(math.ceil(end) + 1 - math.floor(start), 0)
    lower, upper = _scanned(silhouette, axis, first, rows, reach)
    half_seen = np.isnan(lower) | np.isnan(upper)
    lower[half_seen] = upper[half_seen] = np.nan
    return Edges(axis, np.arange(first, first + rows, dtype=np.float64), lower, upper)


def limb_sides(silhouette: Silhouette, axis: MedialLine, start: float, end: float, reach: float) -> Array:
    """Upper median offsets (2,) in px along an axis's normal of the limb's two edges between two positions.

    Each side on its own, NaN if most of it is not seen: beside a bent elbow only the arm's back has an edge.
    """
    rows = max(math.ceil(end - start), 1)
    sides = []
    for sign, offsets in zip((-1.0, 1.0), _scanned(silhouette, axis, start, rows, reach), strict=True):
        seen = np.sort(np.abs(offsets[np.isfinite(offsets)]))
        sides.append(sign * seen[len(seen) // 2] if 2 * len(seen) > rows else math.nan)
    return np.array(sides)


def _scanned(silhouette: Silhouette, axis: MedialLine, start: float, rows: int, reach: float) -> tuple[Array, Array]:
    """Offsets (R,) in px of both edges on scan lines 1 px apart, each NaN where it is not found within reach."""
    (x, y), (dx, dy) = axis.at(start).tolist(), axis.direction.tolist()
    return _scan(silhouette.grey, silhouette.level, (x, y, dx, dy), rows, max(2, math.ceil(reach)))


@compiled
def _scan(
    grey: NDArray[np.uint8], level: float, axis: tuple[float, float, float, float], rows: int, reach: int
) -> tuple[Array, Array]:
    x, y, dx, dy = axis
    lower, upper, values = np.empty(rows), np.empty(rows), np.empty(reach + 1)
    for row in range(rows):
        lower[row] = -_edge(grey, level, (x + row * dx, y + row * dy, dy, -dx), values)
        upper[row] = _edge(grey, level, (x + row * dx, y + row * dy, -dy, dx), values)
    return lower, upper


@compiled
def _edge(grey: NDArray[np.uint8], level: float, ray: tuple[float, float, float, float], values: Array) -> float:
    """Px along a ray (x, y and a unit step) to the edge: found where the values first drop below the level, located
    where they fall most, which is right also for skin in shadow; NaN beyond the picture, whose border would seem to go
    on for ever. `values` is a buffer for those along the ray."""
    x, y, step_x, step_y = ray
    if not _within(grey, x, y):
        return math.nan
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
    if first == 0 or first > reach or not _within(grey, x + first * step_x, y + first * step_y):
        return math.nan
    last = min(first + EDGE_REACH, reach)
    total, position = 0.0, 0.0
    for k in range(max(first - EDGE_REACH, 0), last):
        fall = values[k] - values[k + 1]
        if fall > 0:
            total += fall * fall
            position += fall * fall * (k + 0.5)
    return position / total if total > 0 else math.nan


@compiled
def _within(grey: NDArray[np.uint8], x: float, y: float) -> bool:
    """Return whether a position in px lies within the picture."""
    height, width = grey.shape
    return bool(0.0 <= x <= width - 1.0 and 0.0 <= y <= height - 1.0)


def medial_line(edges: Edges, start: float, end: float) -> MedialLine | None:
    """The medial line of the limb between start and end along the scan axis, or None with too few clean rows.

    All P x R midpoints of upper and lower edge have the mean (a + b) / 2 and the covariance (Ca + Cb) / 4, so the line
    costs O(P + R); both edges cover the same rows, so that a taper does not tilt it.
    """
    count, position, middle, along, across = _middle(*edges.rows, start, end)
    if count < MIN_ROWS:
        return None
    axis = edges.axis
    return MedialLine(axis.at(position) + middle * axis.normal, along * axis.direction + across * axis.normal)


@compiled
def _middle(t: Array, lower: Array, upper: Array, start: float, end: float) -> tuple[int, float, float, float, float]:
    """The number of clean rows, their mean along the scan axis and across, the line's direction along and across."""
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
    """The upper median of the widths in px between two positions along the scan axis, NaN if no row is clean."""
    widths, count = np.empty(len(t)), 0
    for k in range(len(t)):
        if start <= t[k] <= end and not math.isnan(lower[k]):
            widths[count] = upper[k] - lower[k]
            count += 1
    return float(np.sort(widths[:count])[count // 2]) if count else math.nan
