"""The smallest capsule around points; pure."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import fmin

from common.geometry import Array

STARTS = 3  # directions that the search begins with: the points' principal axes
ROUNDING = 1e-9
LEAST_RADIUS_M = 1e-4
AXES = np.eye(3)


@dataclass(frozen=True, slots=True, eq=False)
class Capsule:
    """Its axis from `start` to `end` (3,) and its radius, m."""

    start: Array
    end: Array
    radius: float

    @property
    def volume(self) -> float:
        """m³."""
        length = math.sqrt(float((self.end - self.start) @ (self.end - self.start)))
        return math.pi * self.radius**2 * (length + 4.0 / 3.0 * self.radius)

    def outside(self, points: Array) -> float:
        """Compute how far the farthest of some points (m x 3) is outside, m; not above 0 where all are inside."""
        axis = self.end - self.start
        square = float(axis @ axis)
        along = np.clip((points - self.start) @ axis / square, 0.0, 1.0) if square else np.zeros(len(points))
        away = points - self.start - along[:, None] * axis
        return float(np.sqrt((away * away).sum(axis=1)).max()) - self.radius


def enclosing_capsule(points: Array, *, exactly: bool = True) -> Capsule:
    """The smallest capsule that was found around points (m x 3) in m; roughly, along a principal axis, in much less
    time."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    own = points - middle
    axes = np.linalg.eigh(own.T @ own + ROUNDING * np.eye(3))[1].T[::-1]
    tried = [_start_of(own, axis) for axis in axes[:STARTS]]
    if exactly:
        tried += [_better(own, start) for start in tried]
    return _moved(min((_capsule(own, start) for start in tried), key=lambda capsule: capsule.volume), middle)


def _start_of(points: Array, axis: Array) -> Array:
    """A search's start: direction (3,) and the middle of what is seen along it (2,)."""
    u, v = _across(axis)
    seen = points @ np.column_stack([u, v])
    return np.concatenate([axis, (seen.min(axis=0) + seen.max(axis=0)) / 2])


def _better(points: Array, start: Array) -> Array:
    def volume(x: Array) -> float:
        return _capsule(points, x).volume

    better: Array = fmin(
        volume,
        start,
        xtol=1e-5,
        ftol=1e-9,
        maxfun=500,
        disp=False,
        initial_simplex=_simplex(points, start),
    )
    return better


def _simplex(points: Array, start: Array) -> Array:
    """Steps of 0.2 rad and of a tenth of the points' extent."""
    extent = float(np.ptp(points, axis=0).max())
    return np.vstack([start, start + np.diag([0.2, 0.2, 0.2, 0.1 * extent, 0.1 * extent])])


def _capsule(points: Array, x: Array) -> Capsule:
    """The smallest capsule of a direction (3,) about an axis through a place (2,) across it."""
    axis = x[:3] / max(math.sqrt(float(x[:3] @ x[:3])), ROUNDING)
    u, v = _across(axis)
    along, off_u, off_v = points @ axis, points @ u - x[3], points @ v - x[4]
    square = off_u**2 + off_v**2
    radius = max(math.sqrt(float(square.max())), LEAST_RADIUS_M) + ROUNDING
    caps = np.sqrt(np.maximum(radius**2 - square, 0.0))
    low, high = float((along + caps).min()), float((along - caps).max())
    if low > high:  # one ball encloses all
        low = high = (low + high) / 2
    foot = x[3] * u + x[4] * v
    return Capsule(foot + low * axis, foot + high * axis, radius)


def _across(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors across an axis and each other."""
    u = _crossed(axis, AXES[int(np.argmin(np.abs(axis)))])
    u /= math.sqrt(float(u @ u))
    return u, _crossed(axis, u)


def _crossed(one: Array, other: Array) -> Array:
    """The cross product of two vectors (3,), in a tenth of the time that NumPy takes for so few numbers."""
    (x, y, z), (u, v, w) = one.tolist(), other.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def _moved(capsule: Capsule, by: Array) -> Capsule:
    return Capsule(capsule.start + by, capsule.end + by, capsule.radius + ROUNDING)
