"""Centres of rotation of a tracked point (thesis equations 5.2 and 5.3): by spheres and circles; pure."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle in space: its centre (3,), its axis (3,) of unit length, and its radius in the points' unit."""

    centre: Array
    axis: Array
    radius: float


def windows(rows: Array, size: int) -> Array:
    """Every run of consecutive rows, (N - size + 1, size, columns)."""
    return np.stack([rows[k : k + size] for k in range(len(rows) - size + 1)])


def fit_sphere(points: Array) -> tuple[Array, float]:
    """Centre (3,) and radius of the sphere with the least sum of (|point - centre|² - radius²)², of points (N, 3).

    Equation 5.3 with the square that its print lacks. Of points on one plane the noise decides how far the centre lies
    off the plane; of exact ones it lies on it.
    """
    middle = points.mean(axis=0)
    centre, radius = _fit_round(points - middle)
    return middle + centre, radius


def fit_circle(points: Array) -> Circle:
    """The circle of equation 5.3 within the plane that fits points (N, 3) best."""
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle, full_matrices=False)[2]
    centre, radius = _fit_round((points - middle) @ axes[:2].T)
    return Circle(middle + centre @ axes[:2], axes[2], radius)


def across_axis(vectors: Array, axis: Array) -> Array:
    """Vectors (N, 3) less their part along an axis (3,) of unit length."""
    across: Array = vectors - (vectors @ axis)[:, None] * axis
    return across


def _fit_round(points: Array) -> tuple[Array, float]:
    """Centre (d,) and radius by |p|² = 2 c·p + (radius² - |c|²), linear in c and the constant; points (N, d)."""
    squares = np.sum(points * points, axis=1)
    solution = np.linalg.lstsq(np.column_stack([2.0 * points, np.ones(len(points))]), squares, rcond=1e-9)[0]
    centre = solution[:-1]
    return centre, float(np.sqrt(max(solution[-1] + centre @ centre, 0.0)))
