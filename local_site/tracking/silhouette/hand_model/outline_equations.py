"""Normal equations of a hand's state from outline pixels: signed distances from the projected capsules; compiled."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES, HandSpheres

MIN_LENGTH_PX = 1e-3
MAX_TAPER = 0.95


class Circles(NamedTuple):
    """The spheres in a view: centres (S, 2) and radii (S,) in px, their Jacobians by the state (S, 2, P), (S, P)."""

    centres: Array
    radii: Array
    centre_jacobian: Array
    radius_jacobian: Array


class Contact(NamedTuple):
    """The points of the model nearest to N outline pixels: signed distance (N,) in px, positive outside, the capsule
    (N,), and the fraction (N,) of its length."""

    distance: Array
    capsule: NDArray[np.intp]
    fraction: Array


@compiled
def project_spheres(projection: Array, focal_px: float, spheres: HandSpheres) -> Circles:
    """The circles of spheres in a view, by its projection (3, 4) and focal length."""
    sphere_centres, sphere_radii, moving, growing = spheres
    count, states = growing.shape
    centres, radii = np.empty((count, 2)), np.empty(count)
    moved, growth = np.empty((count, 2, states)), np.empty((count, states))
    for s in range(count):
        x, y, z = sphere_centres[s]
        depth = projection[2, 0] * x + projection[2, 1] * y + projection[2, 2] * z + projection[2, 3]
        scale = focal_px / depth
        radii[s] = sphere_radii[s] * scale
        growth[s] = growing[s] * scale
        for d in range(2):
            row = projection[d]
            centres[s, d] = (row[0] * x + row[1] * y + row[2] * z + row[3]) / depth
            slope = (row[:3] - centres[s, d] * projection[2, :3]) / depth
            for p in range(states):
                moved[s, d, p] = slope[0] * moving[s, 0, p] + slope[1] * moving[s, 1, p] + slope[2] * moving[s, 2, p]
    return Circles(centres, radii, moved, growth)


@compiled
def _capsule_frames(centres: Array, radii: Array) -> Array:
    """For each capsule (K, 5): direction x, y, length in px, slope of its sides, change of its radius along it."""
    frames = np.empty((len(CAPSULES), 5))
    for k in range(len(CAPSULES)):
        a, b = CAPSULES[k]
        dx, dy = centres[b, 0] - centres[a, 0], centres[b, 1] - centres[a, 1]
        length = max(math.sqrt(dx * dx + dy * dy), MIN_LENGTH_PX)
        sine = min(max((radii[a] - radii[b]) / length, -MAX_TAPER), MAX_TAPER)
        frames[k, 0], frames[k, 1], frames[k, 2] = dx / length, dy / length, length
        frames[k, 3], frames[k, 4] = sine / math.sqrt(1 - sine * sine), (radii[b] - radii[a]) / length
    return frames


@compiled
def touch(pixels: Array, circles: Circles) -> Contact:
    """The contacts of pixels (N, 2) with the union of capsules."""
    centres, radii, frames = circles.centres, circles.radii, _capsule_frames(circles.centres, circles.radii)
    distances, nearest, fractions = np.full(len(pixels), np.inf), np.zeros(len(pixels), np.intp), np.empty(len(pixels))
    for n in range(len(pixels)):
        for k in range(len(CAPSULES)):
            ux, uy, length, slope, taper = frames[k]
            a = CAPSULES[k, 0]
            dx, dy = pixels[n, 0] - centres[a, 0], pixels[n, 1] - centres[a, 1]
            along, across = dx * ux + dy * uy, abs(dx * uy - dy * ux)
            foot = min(max(along - across * slope, 0.0), length)
            distance = math.sqrt((along - foot) ** 2 + across * across) - radii[a] - foot * taper
            if distance < distances[n]:
                distances[n], nearest[n], fractions[n] = distance, k, foot / length
    return Contact(distances, nearest, fractions)


@compiled
def add_outline(
    pixels: Array, contact: Contact, circles: Circles, sigma: float, robust: float, information: Array, gradient: Array
) -> float:
    """Add outline pixels to the gradient (P,) and to the lower half of the information (P, P); returns their robust
    (Cauchy) cost."""
    (distances, nearest, fractions), (centres, _, moved, growth) = contact, circles
    cost, row = 0.0, np.empty(len(gradient))
    for n in range(len(pixels)):
        a, b = CAPSULES[nearest[n]]
        t = fractions[n]
        nx = pixels[n, 0] - (1 - t) * centres[a, 0] - t * centres[b, 0]
        ny = pixels[n, 1] - (1 - t) * centres[a, 1] - t * centres[b, 1]
        norm = max(math.sqrt(nx * nx + ny * ny), MIN_LENGTH_PX) * sigma
        nx, ny = nx / norm, ny / norm
        for p in range(len(row)):
            first = nx * moved[a, 0, p] + ny * moved[a, 1, p] + growth[a, p] / sigma
            second = nx * moved[b, 0, p] + ny * moved[b, 1, p] + growth[b, p] / sigma
            row[p] = -(1 - t) * first - t * second
        residual = distances[n] / sigma
        square = (residual / robust) ** 2
        cost += math.log1p(square) * robust**2
        add_row(information, gradient, row, residual, 1.0 / (1.0 + square))
    return cost


@compiled
def add_outside(
    field: NDArray[np.float32],
    origin: Array,
    circles: Circles,
    count: int,
    sigma: float,
    weights: tuple[float, float],
    information: Array,
    gradient: Array,
) -> float:
    """Add those of the first `count` spheres that lie partly outside the silhouette, by its distance field (H, W) in px
    with its first pixel at `origin` (2,); returns their cost.

    Each has the first weight, and less beyond the second, a number of standard deviations.
    """
    centres, radii, moved, growth = circles
    cost, row = 0.0, np.empty(len(gradient))
    for s in range(count):
        room, slope_x, slope_y = _sample(field, centres[s, 0] - origin[0], centres[s, 1] - origin[1])
        residual = (room - radii[s]) / sigma
        if residual >= 0:
            continue
        for p in range(len(row)):
            row[p] = (slope_x * moved[s, 0, p] + slope_y * moved[s, 1, p] - growth[s, p]) / sigma
        weight = weights[0] / max(1.0, -residual / weights[1])
        cost += weight * residual * residual
        add_row(information, gradient, row, residual, weight)
    return cost


@compiled
def _sample(field: NDArray[np.float32], px: float, py: float) -> tuple[float, float, float]:
    """The field and its gradient, interpolated bilinearly; beyond its border it decreases with the distance."""
    height, width = field.shape
    x, y = min(max(px, 1.0), width - 3.0), min(max(py, 1.0), height - 3.0)
    i, j = int(x), int(y)
    u, v = x - i, y - j
    a, b, c, d = field[j, i], field[j, i + 1], field[j + 1, i], field[j + 1, i + 1]
    value = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d) - math.sqrt((px - x) ** 2 + (py - y) ** 2)
    return value, (1 - v) * (b - a) + v * (d - c), (1 - u) * (c - a) + u * (d - b)


@compiled
def add_row(information: Array, gradient: Array, row: Array, residual: float, weight: float) -> None:
    """Add one weighted row to the normal equations; only the lower half of the information is kept."""
    for p in range(len(row)):
        w = weight * row[p]
        gradient[p] += w * residual
        for q in range(p + 1):
            information[p, q] += w * row[q]
