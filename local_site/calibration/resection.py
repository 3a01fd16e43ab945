"""Resection: one camera from control points, with no more numbers than the points speak for."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.special import fdtrc

from common.geometry import Array
from local_site.calibration.physical_camera import ASPECT, BASE, K1, K2, NUMBERS, PhysicalCamera

SIGNIFICANCE = 0.01
ROUNDING_PX = 1e-4
MAX_CONDITION = 1e14
SPARE_NUMBERS = 4
TOLERANCE = 1e-13
LENS_NAMES = {(): "no distortion", (K1,): "k1", (K1, K2): "k1 and k2"}


@dataclass(frozen=True)
class Resection:
    """A fitted camera, the numbers that were free, residuals (N, 2) in px (model less measured), slope (N, 2, free)."""

    camera: PhysicalCamera
    free: tuple[int, ...]
    residuals: Array
    slope: Array

    @property
    def square_sum(self) -> float:
        """Sum of squared residuals, px²."""
        return float(np.sum(self.residuals**2))

    @cached_property
    def normal(self) -> Array:
        """The normal matrix of the fit."""
        flat = self.slope.reshape(-1, len(self.free))
        result: Array = flat.T @ flat
        return result

    def without(self, index: int) -> PhysicalCamera | None:
        """The camera that the other points alone would give, to first order; None where they would not do."""
        scale = 1.0 / np.sqrt(np.maximum(np.diag(self.normal), 1e-300))
        rest = (self.normal - self.slope[index].T @ self.slope[index]) * np.outer(scale, scale)
        if np.linalg.cond(rest) > MAX_CONDITION:
            return None
        step = scale * np.linalg.solve(rest, (self.slope[index].T @ self.residuals[index]) * scale)
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
        flat: Array = (simple.stepped(scattered(values, free)).pixels(points) - pixels).ravel()
        return flat

    zero = np.zeros(len(free))
    fit = least_squares(
        residuals, zero, "3-point", method="lm", x_scale="jac", ftol=TOLERANCE, xtol=TOLERANCE, gtol=TOLERANCE
    )
    camera = simple.stepped(scattered(fit.x, free))
    slope = np.asarray(fit.jac, dtype=np.float64).reshape(-1, 2, len(free))
    return Resection(camera, free, camera.pixels(points) - pixels, slope)


def choose_camera(points: Array, pixels: Array, start: PhysicalCamera) -> tuple[Resection, str]:
    """The camera with as few numbers as an F-test at 1 % lets the residuals get by with; and why, in words.

    From the fullest camera that the count of points allows, fy apart from fx, then k2, then k1 are left out, each
    wherever leaving it out costs no more than noise would.
    """
    enough = 2 * len(points) >= NUMBERS + SPARE_NUMBERS
    chosen = fit_camera(points, pixels, start, (*BASE, ASPECT, K1, K2) if enough else (*BASE, ASPECT))
    reasons = []
    for number in (ASPECT, K2, K1):
        if number not in chosen.free or (number == K1 and K2 in chosen.free):
            continue
        simple = fit_camera(points, pixels, chosen.camera, tuple(n for n in chosen.free if n != number))
        chance = chance_of_noise(simple, chosen)
        if number != ASPECT:
            reasons.append(f"{'k1' if number == K1 else 'k2'} p = {chance:.2g}")
        if chance >= SIGNIFICANCE or folds(chosen.camera, points):
            chosen = simple
    lens = LENS_NAMES[tuple(n for n in chosen.free if n >= K1)]
    pixel = "square pixels" if ASPECT not in chosen.free else "fx apart from fy"
    return chosen, f"{lens}, {pixel} (F-test: {', '.join(reasons) or 'too few points'})"


def chance_of_noise(simple: Resection, rich: Resection) -> float:
    """How probably noise alone would let the richer model fit as much better as it does (F-test)."""
    added = len(rich.free) - len(simple.free)
    count = rich.residuals.size
    freedom = count - len(rich.free)
    floor = count * ROUNDING_PX**2
    ratio = ((simple.square_sum - rich.square_sum) / added) / ((rich.square_sum + floor) / freedom)
    return float(fdtrc(added, freedom, max(ratio, 0.0)))


def folds(camera: PhysicalCamera, points: Array) -> bool:
    """Whether the lens turns the picture back on itself among the points: a distortion that cannot be real."""
    in_camera = camera.to_camera(points)
    return camera.lens.folds_within(float(np.max(np.linalg.norm(in_camera[:, :2] / in_camera[:, 2:], axis=1))))
