"""What outline pixels say of a hand's state: signed distances from projected capsules, summed to normal equations."""

import math

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled

MIN_LENGTH_PX = 1e-3
MAX_TAPER = 0.95


@compiled
def project_spheres(
    projection: Array, focal_px: float, centres: Array, radii: Array, moving: Array, growing: Array
) -> tuple[Array, Array, Array, Array]:
    """Circles of spheres in a view: centres (S, 2) and radii (S,) in px, their change with the state (S, 2, P), (S, P).

    Spheres are centres (S, 3) and radii (S,) in m with changes (S, 3, P) and (S, P).
    """
    spheres, states = growing.shape
    places, circles = np.empty((spheres, 2)), np.empty(spheres)
    moved, growth = np.empty((spheres, 2, states)), np.empty((spheres, states))
    for s in range(spheres):
        x, y, z = centres[s]
        depth = projection[2, 0] * x + projection[2, 1] * y + projection[2, 2] * z + projection[2, 3]
        scale = focal_px / depth
        circles[s] = radii[s] * scale
        growth[s] = growing[s] * scale
        for d in range(2):
            row = projection[d]
            places[s, d] = (row[0] * x + row[1] * y + row[2] * z + row[3]) / depth
            slope = (row[:3] - places[s, d] * projection[2, :3]) / depth
            for p in range(states):
                moved[s, d, p] = slope[0] * moving[s, 0, p] + slope[1] * moving[s, 1, p] + slope[2] * moving[s, 2, p]
    return places, circles, moved, growth


@compiled
def capsule_frames(places: Array, circles: Array, capsules: NDArray[np.intp]) -> Array:
    """Of each capsule (K, 5): direction x, y, length in px, slope of its sides, change of its radius along it."""
    frames = np.empty((len(capsules), 5))
    for k in range(len(capsules)):
        a, b = capsules[k]
        dx, dy = places[b, 0] - places[a, 0], places[b, 1] - places[a, 1]
        length = max(math.sqrt(dx * dx + dy * dy), MIN_LENGTH_PX)
        sine = min(max((circles[a] - circles[b]) / length, -MAX_TAPER), MAX_TAPER)
        frames[k, 0], frames[k, 1], frames[k, 2] = dx / length, dy / length, length
        frames[k, 3], frames[k, 4] = sine / math.sqrt(1 - sine * sine), (circles[b] - circles[a]) / length
    return frames


@compiled
def touch(
    pixels: Array, places: Array, circles: Array, capsules: NDArray[np.intp], frames: Array
) -> tuple[Array, NDArray[np.intp], Array]:
    """Signed distances (N,) of pixels from the union of capsules, positive outside, the nearest capsule (N,), and the
    share of its length (N,) where it is nearest."""
    distances, nearest, shares = np.full(len(pixels), np.inf), np.zeros(len(pixels), np.intp), np.empty(len(pixels))
    for n in range(len(pixels)):
        for k in range(len(capsules)):
            ux, uy, length, slope, taper = frames[k]
            a = capsules[k, 0]
            dx, dy = pixels[n, 0] - places[a, 0], pixels[n, 1] - places[a, 1]
            along, across = dx * ux + dy * uy, abs(dx * uy - dy * ux)
            foot = min(max(along - across * slope, 0.0), length)
            distance = math.sqrt((along - foot) ** 2 + across * across) - circles[a] - foot * taper
            if distance < distances[n]:
                distances[n], nearest[n], shares[n] = distance, k, foot / length
    return distances, nearest, shares


@compiled
def add_outline(
    pixels: Array,
    contact: tuple[Array, NDArray[np.intp], Array],
    view: tuple[Array, Array, Array, Array],
    capsules: NDArray[np.intp],
    sigma: float,
    robust: float,
    information: Array,
    gradient: Array,
) -> float:
    """Add what outline pixels say to the gradient (P,) and to the lower half of information (P, P); returns their
    robust cost."""
    (distances, nearest, shares), (places, _, moved, growth) = contact, view
    cost, row = 0.0, np.empty(len(gradient))
    for n in range(len(pixels)):
        a, b = capsules[nearest[n]]
        t = shares[n]
        nx = pixels[n, 0] - (1 - t) * places[a, 0] - t * places[b, 0]
        ny = pixels[n, 1] - (1 - t) * places[a, 1] - t * places[b, 1]
        norm = max(math.sqrt(nx * nx + ny * ny), MIN_LENGTH_PX) * sigma
        nx, ny = nx / norm, ny / norm
        for p in range(len(row)):
            first = nx * moved[a, 0, p] + ny * moved[a, 1, p] + growth[a, p] / sigma
            second = nx * moved[b, 0, p] + ny * moved[b, 1, p] + growth[b, p] / sigma
            row[p] = -(1 - t) * first - t * second
        residual = distances[n] / sigma
        square = (residual / robust) ** 2
        cost += math.log1p(square) * robust**2
        _add(information, gradient, row, residual, 1.0 / (1.0 + square))
    return cost


@compiled
def add_outside(
    field: NDArray[np.float32],
    origin: Array,
    view: tuple[Array, Array, Array, Array],
    count: int,
    sigma: float,
    weights: tuple[float, float],
    information: Array,
    gradient: Array,
) -> float:
    """Add the first `count` spheres that stick out of the silhouette, by its distance field; returns their cost.

    Each weighs the first weight, less from the second, in standard deviations, on.
    """
    places, circles, moved, growth = view
    cost, row = 0.0, np.empty(len(gradient))
    for s in range(count):
        room, slope_x, slope_y = _sample(field, places[s, 0] - origin[0], places[s, 1] - origin[1])
        residual = (room - circles[s]) / sigma
        if residual >= 0:
            continue
        for p in range(len(row)):
            row[p] = (slope_x * moved[s, 0, p] + slope_y * moved[s, 1, p] - growth[s, p]) / sigma
        weight = weights[0] / max(1.0, -residual / weights[1])
        cost += weight * residual * residual
        _add(information, gradient, row, residual, weight)
    return cost


@compiled
def _sample(field: NDArray[np.float32], px: float, py: float) -> tuple[float, float, float]:
    """The field and its slope between its pixels; beyond its rim it goes on falling."""
    height, width = field.shape
    x, y = min(max(px, 1.0), width - 3.0), min(max(py, 1.0), height - 3.0)
    i, j = int(x), int(y)
    u, v = x - i, y - j
    a, b, c, d = field[j, i], field[j, i + 1], field[j + 1, i], field[j + 1, i + 1]
    value = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d) - math.sqrt((px - x) ** 2 + (py - y) ** 2)
    return value, (1 - v) * (b - a) + v * (d - c), (1 - u) * (c - a) + u * (d - b)


@compiled
def _add(information: Array, gradient: Array, row: Array, residual: float, weight: float) -> None:
    """Add one weighted row to the normal equations, of whose information only the lower half is kept."""
    for p in range(len(row)):
        w = weight * row[p]
        gradient[p] += w * residual
        for q in range(p + 1):
            information[p, q] += w * row[q]
