"""The edges around a finger tip in one view, added to the equations of its place; compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.tracking.silhouette.compiled import compiled

PIXEL_SIGMA = 1.7
REACH_PX = 3.0
CAP_BACK = 0.3
AHEAD = 0.7
EDGE_SIGMA = 2.5
EDGE_ANGLES = np.radians(np.arange(-75.0, 76.0, 15.0))
EDGE_STEPS = 12
MIN_EDGE = 0.08
MIN_DISTANCE_PX = 1e-6

TipSphere = tuple[Array, Array, float]
"""Centre of the tip's sphere (3,), of the joint before it (3,), and its radius, in m."""


@compiled
def _circle(projection: Array, focal_px: float, tip: TipSphere) -> tuple[Array, float, Array, Array]:
    """The tip in the view: centre (2,) and radius in px, direction of the finger (2,), px per m (2, 3)."""
    h, g = projection[:, 3].copy(), projection[:, 3].copy()
    for d in range(3):
        h += projection[:, d] * tip[0][d]
        g += projection[:, d] * tip[1][d]
    centre = h[:2] / h[2]
    ahead = centre - g[:2] / g[2]
    ahead /= max(math.sqrt(ahead[0] ** 2 + ahead[1] ** 2), MIN_DISTANCE_PX)
    gradient = np.empty((2, 3))
    for d in range(2):
        gradient[d] = (projection[d, :3] - centre[d] * projection[2, :3]) / h[2]
    return centre, tip[2] * focal_px / h[2], ahead, gradient


@compiled
def _add(
    gradient: Array, nx: float, ny: float, residual_px: float, sigma: float, information: Array, pull: Array
) -> None:
    row = -(nx * gradient[0] + ny * gradient[1]) / sigma
    for p in range(3):
        pull[p] += row[p] * residual_px / sigma
        for q in range(3):
            information[p, q] += row[p] * row[q]


@compiled
def add_outline_pixels(
    projection: Array, focal_px: float, pixels: Array, tip: TipSphere, information: Array, pull: Array
) -> int:
    """Add outline pixels (N, 2) close around the tip's end to information (3, 3) and pull (3,).

    Returns how many lie ahead of it: an outline that only passes beside a tip does not show where it ends.
    """
    centre, radius, ahead, gradient = _circle(projection, focal_px, tip)
    count = 0
    for n in range(len(pixels)):
        x, y = pixels[n, 0] - centre[0], pixels[n, 1] - centre[1]
        distance = max(math.sqrt(x * x + y * y), MIN_DISTANCE_PX)
        forward = x * ahead[0] + y * ahead[1]
        if abs(distance - radius) < REACH_PX and forward > -CAP_BACK * radius:
            count += forward > AHEAD * distance
            _add(gradient, x / distance, y / distance, distance - radius, PIXEL_SIGMA, information, pull)
    return count


@compiled
def add_grey_edges(
    projection: Array,
    focal_px: float,
    grey: NDArray[np.uint8],
    shift: Array,
    tip: TipSphere,
    information: Array,
    pull: Array,
) -> None:
    """Add the clearest edges of grey on rays from the tip's centre, where it ends before or beside another finger.

    `shift` (2,) takes the picture to the instant measured.
    """
    centre, radius, ahead, gradient = _circle(projection, focal_px, tip)
    values = np.empty(EDGE_STEPS + 1)
    for angle in EDGE_ANGLES:
        nx = math.cos(angle) * ahead[0] - math.sin(angle) * ahead[1]
        ny = math.sin(angle) * ahead[0] + math.cos(angle) * ahead[1]
        for k in range(EDGE_STEPS + 1):
            along = radius - REACH_PX + 2 * REACH_PX * k / EDGE_STEPS
            values[k] = _value(grey, centre[0] + along * nx - shift[0], centre[1] + along * ny - shift[1])
        best, clearest = 0, 0.0
        for k in range(1, EDGE_STEPS):
            change = abs(values[k + 1] - values[k - 1])
            if change > clearest:
                best, clearest = k, change
        if clearest > MIN_EDGE * max(values.max(), 1.0):
            residual = -REACH_PX + 2 * REACH_PX * best / EDGE_STEPS
            _add(gradient, nx, ny, residual, EDGE_SIGMA, information, pull)


@compiled
def _value(grey: NDArray[np.uint8], x: float, y: float) -> float:
    """The grey value between pixels, the border's beyond it."""
    height, width = grey.shape
    x, y = min(max(x, 0.0), width - 1.001), min(max(y, 0.0), height - 1.001)
    i, j = int(x), int(y)
    u, v = x - i, y - j
    above = (1 - u) * grey[j, i] + u * grey[j, i + 1]
    below = (1 - u) * grey[j + 1, i] + u * grey[j + 1, i + 1]
    return float((1 - v) * above + v * below)
