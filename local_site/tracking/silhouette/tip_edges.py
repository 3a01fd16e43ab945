"""The edges around a finger tip in one view, added to the equations of its place; compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.pixels import grey_at

PIXEL_SIGMA = 1.4
REACH_PX = 3.0
CAP_BACK = 0.3
AHEAD = 0.7
EDGE_SIGMA = 2.5
EDGE_ANGLES = np.radians(np.arange(-75.0, 76.0, 15.0))
EDGE_STEPS = 12
MIN_EDGE = 0.08
MIN_DISTANCE_PX = 1e-6
MIN_PIXELS, END_SHARE = 3, 0.7  # of outline before the tip: at least, and in units of its radius
STEPS = 3

TipSphere = tuple[Array, Array, float]
"""Centre of the tip's sphere (3,), of the joint before it (3,), and its radius, in m."""


Circle = tuple[Array, float, Array, Array]
"""A tip in a view: centre (2,) and radius in px, direction of the finger (2,), px per m (2, 3)."""

View = tuple[Array, float, Array, NDArray[np.intp], NDArray[np.uint8], Array]
"""Projection (3, 4), focal length in px, outline pixels (N, 2), the model's capsule (N,) that each touches, the grey
picture, empty where there is no view, and the shift (2,) that takes it to the instant measured."""


@compiled
def settle(
    views: tuple[View, ...], owned: NDArray[np.bool_], tip: TipSphere, freedom_m: float
) -> tuple[Array, Array, int]:
    """Move a tip to its edges: its shift (3,), the covariance (3, 3) of that, and how many views show it in outline.

    `owned` says which capsules (K,) end in the tip, which may move by about `freedom_m`.
    """
    shift, information, seen = np.zeros(3), np.eye(3), 0
    for _ in range(STEPS):
        information, pull, seen = np.eye(3) / freedom_m**2, shift / freedom_m**2, 0
        moved = (tip[0] + shift, tip[1] + shift, tip[2])
        for projection, focal_px, outline, capsules, grey, to_now in views:
            if grey.size == 0:
                continue
            circle = _circle(projection, focal_px, moved)
            if _add_outline(circle, outline, owned, capsules, information, pull) >= max(
                MIN_PIXELS, END_SHARE * circle[1]
            ):
                seen += 1
            else:
                _add_grey_edges(circle, grey, to_now, information, pull)
        shift = shift - np.linalg.solve(information, pull)
    return shift, np.linalg.inv(information).astype(np.float64), seen


@compiled
def _circle(projection: Array, focal_px: float, tip: TipSphere) -> Circle:
    """The tip in the view."""
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
def _add_outline(
    circle: Circle,
    outline: Array,
    owned: NDArray[np.bool_],
    capsules: NDArray[np.intp],
    information: Array,
    pull: Array,
) -> int:
    """Add the tip's own outline pixels close around its end to information (3, 3) and pull (3,).

    Returns how many lie ahead of it: an outline that only passes beside a tip does not show where it ends.
    """
    centre, radius, ahead, gradient = circle
    count = 0
    for n in range(len(outline)):
        if not owned[capsules[n]]:
            continue
        x, y = outline[n, 0] - centre[0], outline[n, 1] - centre[1]
        distance = max(math.sqrt(x * x + y * y), MIN_DISTANCE_PX)
        forward = x * ahead[0] + y * ahead[1]
        if abs(distance - radius) < REACH_PX and forward > -CAP_BACK * radius:
            count += forward > AHEAD * distance
            _add(gradient, x / distance, y / distance, distance - radius, PIXEL_SIGMA, information, pull)
    return count


@compiled
def _add_grey_edges(circle: Circle, grey: NDArray[np.uint8], shift: Array, information: Array, pull: Array) -> None:
    """Add the clearest edges of grey on rays from the tip's centre, where it ends before or beside another finger.

    `shift` (2,) takes the picture to the instant measured.
    """
    centre, radius, ahead, gradient = circle
    values = np.empty(EDGE_STEPS + 1)
    for angle in EDGE_ANGLES:
        nx = math.cos(angle) * ahead[0] - math.sin(angle) * ahead[1]
        ny = math.sin(angle) * ahead[0] + math.cos(angle) * ahead[1]
        for k in range(EDGE_STEPS + 1):
            along = radius - REACH_PX + 2 * REACH_PX * k / EDGE_STEPS
            values[k] = grey_at(grey, centre[0] + along * nx - shift[0], centre[1] + along * ny - shift[1])
        best, clearest = 0, 0.0
        for k in range(1, EDGE_STEPS):
            change = abs(values[k + 1] - values[k - 1])
            if change > clearest:
                best, clearest = k, change
        if clearest > MIN_EDGE * max(values.max(), 1.0):
            residual = -REACH_PX + 2 * REACH_PX * best / EDGE_STEPS
            _add(gradient, nx, ny, residual, EDGE_SIGMA, information, pull)
