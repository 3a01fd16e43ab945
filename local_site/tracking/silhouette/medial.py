"""Medial lines of limbs: total least squares through the midpoints of the two edges (thesis 3.1.6, 3.1.7)."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.tracking.silhouette.contour import Silhouette

MIN_ROWS = 6
WIDTH_TOLERANCE = 1.4


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
    patch = cv2.warpAffine(silhouette.grey, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    values = patch.astype(np.float64) - silhouette.level
    upper = _crossing(values[:, half:])
    lower = -_crossing(values[:, half::-1])
    return Edges(axis, t, np.where(np.isnan(upper), np.nan, lower), np.where(np.isnan(lower), np.nan, upper))


def _crossing(values: Array) -> Array:
    """Where each row (R, K) of values first falls below zero, from a positive first value; NaN where it never does."""
    dark = values <= 0
    first = np.argmax(dark, axis=1)
    rows = np.arange(len(values))
    inner, outer = values[rows, np.maximum(first - 1, 0)], values[rows, first]
    with np.errstate(divide="ignore", invalid="ignore"):
        place = first - 1 + inner / (inner - outer)
    return np.where(first > 0, place, np.nan)


def medial_line(edges: Edges, start: float, end: float) -> Line | None:
    """The medial line of the limb between start and end along the scan axis, or None with too few clean rows.

    All P x R midpoints of upper and lower edge have the mean (a + b) / 2 and the covariance (Ca + Cb) / 4, so the line
    costs O(P + R); both edges cover the same rows, which keeps a taper from tilting it.
    """
    chosen = (edges.t >= start) & (edges.t <= end) & np.isfinite(edges.lower)
    if np.count_nonzero(chosen) < MIN_ROWS:
        return None
    chosen &= edges.width < WIDTH_TOLERANCE * float(np.median(edges.width[chosen]))
    if np.count_nonzero(chosen) < MIN_ROWS:
        return None
    t = edges.t[chosen]
    a, b = (np.column_stack([t, offsets[chosen]]) for offsets in (edges.upper, edges.lower))
    mean = 0.5 * (a.mean(axis=0) + b.mean(axis=0))
    covariance = 0.25 * (np.cov(a.T, bias=True) + np.cov(b.T, bias=True))
    along, across = _top_eigenvector(covariance)
    axis = edges.axis
    return Line(
        axis.at(float(mean[0])) + mean[1] * axis.normal,
        along * axis.direction + across * axis.normal,
    )


def _top_eigenvector(covariance: NDArray[np.float64]) -> tuple[float, float]:
    """The main direction of a 2 x 2 covariance, pointing along positive t."""
    angle = 0.5 * math.atan2(2 * float(covariance[0, 1]), float(covariance[0, 0] - covariance[1, 1]))
    return math.cos(angle), math.sin(angle)
