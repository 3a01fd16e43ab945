"""Resection: one camera from control points, linearly (DLT, thesis 3.2.9.1) and by least squares.

The camera's model has no more terms than the residuals support (F-test).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import fdtrc

from common.geometry import Array
from local_site.calibration.physical_camera import ASPECT, BASE, K1, K2, NUMBERS, PhysicalCamera
from local_site.calibration.triangulation import project

MIN_POINTS = 6
MIN_FLATNESS = 1e-3
OUTLIER_SIGMAS = 8.0
OUTLIER_PX = 2.0


def solve_projection(points: Array, pixels: Array) -> Array:
    """The projection (3, 4) of one camera from N >= 6 points (N, 3) in m, not coplanar, and their pixels (N, 2).

    The null vector of equations 3.17-3.20 after Hartley's normalisation, scaled to positive depths in m.
    """
    world_T, image_T = _normaliser(points), _normaliser(pixels)
    X = np.column_stack([points, np.ones(len(points))]) @ world_T.T
    u = (np.column_stack([pixels, np.ones(len(pixels))]) @ image_T.T)[:, :2]
    zero = np.zeros_like(X)
    rows = np.concatenate([np.hstack([X, zero, -u[:, :1] * X]), np.hstack([zero, X, -u[:, 1:] * X])])
    normalised = np.linalg.svd(rows, full_matrices=False)[2][-1].reshape(3, 4)
    projection: Array = np.linalg.inv(image_T) @ normalised @ world_T
    depth = float(np.mean(points @ projection[2, :3] + projection[2, 3]))
    return projection / math.copysign(max(float(np.linalg.norm(projection[2, :3])), 1e-300), depth)


def unsolvable(points: Array) -> str:
    """Say why these points (N, 3) cannot determine a camera, with the cure; empty if they may."""
    if len(points) < MIN_POINTS:
        return f"sees {len(points)} control points, needs at least {MIN_POINTS}; show it more of the plate"
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[2] < MIN_FLATNESS * extents[0]:
        return "its control points lie in one plane; put the plate at two or more heights"
    return ""


def agreeing(points: Array, pixels: Array) -> NDArray[np.bool_]:
    """The inliers (N,) of a linear camera; the worst outlier is removed first."""
    kept = np.ones(len(points), dtype=bool)
    residuals = reprojection_errors(solve_projection(points, pixels), points, pixels)
    while True:
        worst = int(np.argmax(np.where(kept, residuals, 0.0)))
        trial = kept.copy()
        trial[worst] = False
        if unsolvable(points[trial]):
            return kept
        residuals = reprojection_errors(solve_projection(points[trial], pixels[trial]), points, pixels)
        if residuals[worst] <= outlier_limit(residuals[trial]):
            return kept
        kept = trial


def outlier_limit(residuals: Array) -> float:
    """The residual in px above which a point is an outlier, given the residuals (N,) of inliers."""
    return max(OUTLIER_PX, OUTLIER_SIGMAS * float(np.median(residuals)))


def reprojection_errors(projection: Array, points: Array, pixels: Array) -> Array:
    """Distances (N,) in px between projected points (N, 3) and pixels (N, 2); infinite where there is no picture."""
    with np.errstate(divide="ignore", invalid="ignore"):
        distances = np.linalg.norm(project(projection, points) - pixels, axis=1)
    return np.where(np.isfinite(distances), distances, np.inf)


def _normaliser(values: Array) -> Array:
    """The similarity that takes values (N, d) to zero mean and mean distance sqrt(d)."""
    dimension = values.shape[1]
    centre = values.mean(axis=0)
    distance = float(np.linalg.norm(values - centre, axis=1).mean())
    scale = math.sqrt(dimension) / max(distance, 1e-12)
    result = np.diag([*[scale] * dimension, 1.0])
    result[:dimension, dimension] = -scale * centre
    return result


SIGNIFICANCE = 0.01
ROUNDING_PX = 1e-4
LENS_WORDS = {(): "no distortion", (K1,): "k1", (K1, K2): "k1 and k2"}


@dataclass(frozen=True)
class ModelFit:
    """A fit: the camera numbers that were free, residuals (N, 2) in px, model less measured, and their Jacobian, whose
    last axis is the fitted numbers."""

    free: tuple[int, ...]
    residuals: Array
    jacobian: Array


F = TypeVar("F", bound=ModelFit)


def choose_model(fullest: F, refit: Callable[[F, tuple[int, ...]], F], unreal: Callable[[F], bool]) -> tuple[F, str]:
    """The simplest fit that is not significantly worse, and why, in words.

    Starting from the fullest fit, fy independent of fx, then k2, then k1 are left out, each if the loss is not
    significant (F-test at 1 %), or if the richer fit is `unreal`.
    """
    chosen, p_values = fullest, []
    for number in (ASPECT, K2, K1):
        if number not in chosen.free or (number == K1 and K2 in chosen.free):
            continue
        simple = refit(chosen, tuple(n for n in chosen.free if n != number))
        p = p_value(simple, chosen)
        if number != ASPECT:
            p_values.append(f"{'k1' if number == K1 else 'k2'} p = {p:.2g}")
        if p >= SIGNIFICANCE or unreal(chosen):
            chosen = simple
    lens = LENS_WORDS[tuple(n for n in chosen.free if n >= K1)]
    pixel = "square pixels" if ASPECT not in chosen.free else "fx apart from fy"
    return chosen, f"{lens}, {pixel} (F-test at 1 %: {', '.join(p_values) or 'too few points'})"


def p_value(simple: ModelFit, rich: ModelFit) -> float:
    """The probability that noise alone makes the richer model fit better by as much as it does (F-test)."""
    count, numbers = rich.residuals.size, rich.jacobian.shape[-1]
    added, freedom = numbers - simple.jacobian.shape[-1], count - numbers
    if freedom < 1:
        return 1.0
    floor = count * ROUNDING_PX**2
    gained = float(np.sum(simple.residuals**2) - np.sum(rich.residuals**2))
    ratio = (gained / added) / ((float(np.sum(rich.residuals**2)) + floor) / freedom)
    return float(fdtrc(added, freedom, max(ratio, 0.0)))


MAX_CONDITION = 1e14
SPARE_NUMBERS = 4
TOLERANCE = 1e-13


@dataclass(frozen=True)
class Resection(ModelFit):
    """A fitted camera; the Jacobian is (N, 2, free)."""

    camera: PhysicalCamera

    @property
    def rms_px(self) -> float:
        """Root mean square distance between model and measurement, px."""
        return float(np.sqrt(np.mean(np.sum(self.residuals**2, axis=1))))

    @cached_property
    def normal(self) -> Array:
        """The normal matrix of the fit."""
        flat = self.jacobian.reshape(-1, len(self.free))
        return flat.T @ flat

    def without(self, index: int) -> PhysicalCamera | None:
        """The camera that the other points alone would give, to first order; None if they do not determine it."""
        scale = 1.0 / np.sqrt(np.maximum(np.diag(self.normal), 1e-300))
        own = self.jacobian[index]
        rest = (self.normal - own.T @ own) * np.outer(scale, scale)
        if np.linalg.cond(rest) > MAX_CONDITION:
            return None
        step = scale * np.linalg.solve(rest, (own.T @ self.residuals[index]) * scale)
        return self.camera.stepped(scattered(step, self.free))


def scattered(values: Array, free: tuple[int, ...]) -> Array:
    """A step (NUMBERS,) that moves only the free numbers."""
    step = np.zeros(NUMBERS)
    step[list(free)] = values
    return step


def fit_camera(points: Array, pixels: Array, start: PhysicalCamera, free: tuple[int, ...]) -> Resection:
    """The camera with the least squared reprojection error: points (N, 3) in m, pixels (N, 2)."""
    simple = start.simplified(free)

    def residuals(values: Array) -> Array:
        return (simple.stepped(scattered(values, free)).pixels(points) - pixels).ravel()

    zero = np.zeros(len(free))
    fit = least_squares(
        residuals, zero, "3-point", method="lm", x_scale="jac", ftol=TOLERANCE, xtol=TOLERANCE, gtol=TOLERANCE
    )
    camera = simple.stepped(scattered(fit.x, free))
    jacobian = np.asarray(fit.jac, dtype=np.float64).reshape(-1, 2, len(free))
    return Resection(free, camera.pixels(points) - pixels, jacobian, camera)


def choose_camera(points: Array, pixels: Array, start: PhysicalCamera) -> tuple[Resection, str]:
    """The camera with no more numbers than points (N, 3) and pixels (N, 2) support; and why, in words."""
    enough = 2 * len(points) >= NUMBERS + SPARE_NUMBERS

    def refit(chosen: Resection, free: tuple[int, ...]) -> Resection:
        return fit_camera(points, pixels, chosen.camera, free)

    fullest = fit_camera(points, pixels, start, (*BASE, ASPECT, K1, K2) if enough else (*BASE, ASPECT))
    return choose_model(fullest, refit, lambda chosen: folds(chosen.camera, points))


def folds(camera: PhysicalCamera, points: Array) -> bool:
    """Return whether the lens's distortion is not invertible among the points, and so cannot be real."""
    in_camera = camera.to_camera(points)
    return camera.lens.folds_within(float(np.max(np.linalg.norm(in_camera[:, :2] / in_camera[:, 2:], axis=1))))
