"""Medial lines of limbs: total least squares through the midpoints of the two edges (thesis 3.1.6, 3.1.7)."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.tracking.silhouette.compiled import compiled
from local_site.tracking.silhouette.contour import Silhouette

MIN_ROWS = 6
WIDTH_TOLERANCE = 1.4
EDGE_REACH = 3


@dataclass(frozen=True, slots=True)
class Line:
    """A line in the image: a point on it (2,) in px and a unit direction (2,)."""

    point: Array
    direction: Array

    @property
    def normal(self) -> Array:
        """The unit normal (2,), the direction turned by +90 deg (x towards y)."""
        return np.array([-self.direction[1], self.direction[0]])

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

    axis: Line
    t: Array
    lower: Array
    upper: Array

    @property
    def width(self) -> Array:
        """Distance between the edges (R,) in px."""
        return self.upper - self.lower


def line_through(start: Array, end: Array) -> Line | None:
    """The line from one pixel to another, or None where they coincide."""
    length = math.hypot(*(end - start))
    return Line(start, (end - start) / length) if length > 1e-6 else None


def scan_edges(silhouette: Silhouette, axis: Line, start: float, end: float, reach: float) -> Edges:
    """The edges of the limb around an axis, to a fraction of a pixel, on scan lines 1 px apart from start to end.

    Each scan line is followed from the axis to both sides until the grey value falls below the threshold.
    """
    t = np.arange(math.floor(start), math.ceil(end) + 1.0)
    half = max(2, math.ceil(reach))
    n, d = axis.normal, axis.direction
    corner = axis.at(t[0]) - half * n
    matrix = np.array([[n[0], d[0], corner[0]], [n[1], d[1], corner[1]]])
    size = (2 * half + 1, len(t))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    patch = np.asarray(
        cv2.warpAffine(silhouette.grey, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE), dtype=np.uint8
    )
    lower, upper = _edges(patch, silhouette.level, half)
    return Edges(axis, t, lower, upper)


@compiled
def _edges(patch: NDArray[np.uint8], level: float, half: int) -> tuple[Array, Array]:
    """Where each row (R, K) falls off on both sides of its middle, px from there; NaN where one side never does."""
    lower, upper = np.full(len(patch), np.nan), np.full(len(patch), np.nan)
    for row in range(len(patch)):
        before, after = _edge(patch[row], level, half, -1), _edge(patch[row], level, half, 1)
        if not (math.isnan(before) or math.isnan(after)):
            lower[row], upper[row] = -before, after
    return lower, upper


@compiled
def _edge(values: NDArray[np.uint8], level: float, middle: int, step: int) -> float:
    """Px from the middle to the edge: found where the values first drop below the level, placed where they fall most,
    which also holds for skin in shadow."""
    reach = len(values) // 2
    first = 0
    while first <= reach and values[middle + step * first] > level:
        first += 1
    if first == 0 or first > reach:
        return math.nan
    total, place = 0.0, 0.0
    for k in range(max(first - EDGE_REACH, 0), min(first + EDGE_REACH, reach)):
        fall = float(values[middle + step * k]) - float(values[middle + step * (k + 1)])
        if fall > 0:
            total += fall * fall
            place += fall * fall * (k + 0.5)
    return place / total if total > 0 else math.nan


def medial_line(edges: Edges, start: float, end: float) -> Line | None:
    """The medial line of the limb between start and end along the scan axis, or None with too few clean rows.

    All P x R midpoints of upper and lower edge have the mean (a + b) / 2 and the covariance (Ca + Cb) / 4, so the line
    costs O(P + R); both edges cover the same rows, which keeps a taper from tilting it.
    """
    chosen = np.flatnonzero((edges.t >= start) & (edges.t <= end) & np.isfinite(edges.lower))
    if len(chosen) < MIN_ROWS:
        return None
    width = edges.width[chosen]
    chosen = chosen[width < WIDTH_TOLERANCE * middle_value(width)]
    if len(chosen) < MIN_ROWS:
        return None
    t, upper, lower = edges.t[chosen], edges.upper[chosen], edges.lower[chosen]
    n = len(chosen)
    mean_t, mean_u, mean_l = (float(v.sum()) / n for v in (t, upper, lower))
    t, upper, lower = t - mean_t, upper - mean_u, lower - mean_l
    along, across = _top_eigenvector(
        0.5 * float(t @ t) / n, 0.25 * float(t @ (upper + lower)) / n, 0.25 * float(upper @ upper + lower @ lower) / n
    )
    axis = edges.axis
    return Line(
        axis.at(mean_t) + 0.5 * (mean_u + mean_l) * axis.normal,
        along * axis.direction + across * axis.normal,
    )


def width_between(edges: Edges, start: float, end: float) -> float | None:
    """The typical width in px between two places along the scan axis, None where no row is clean."""
    chosen = (edges.t >= start) & (edges.t <= end) & np.isfinite(edges.lower)
    return middle_value(edges.width[chosen]) if chosen.any() else None


def middle_value(values: Array) -> float:
    """The upper median of values (N,), N > 0; much quicker than numpy.median on short arrays."""
    return float(np.sort(values)[len(values) // 2])


def _top_eigenvector(tt: float, ts: float, ss: float) -> tuple[float, float]:
    """The main direction of the covariance [[tt, ts], [ts, ss]], pointing along positive t."""
    angle = 0.5 * math.atan2(2 * ts, tt - ss)
    return math.cos(angle), math.sin(angle)
