"""Resection: one camera from control points, with no more numbers than the points speak for."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from common.geometry import Array
from local_site.calibration.model_choice import choose_model
from local_site.calibration.physical_camera import ASPECT, BASE, K1, K2, NUMBERS, PhysicalCamera

MAX_CONDITION = 1e14
SPARE_NUMBERS = 4
TOLERANCE = 1e-13


@dataclass(frozen=True)
class Resection:
    """A fitted camera, the numbers that were free, residuals (N, 2) in px (model less measured), slope (N, 2, free)."""

    camera: PhysicalCamera
    free: tuple[int, ...]
    residuals: Array
    slope: Array

    @property
    def numbers(self) -> int:
        """How many numbers were fitted."""
        return len(self.free)

    @property
    def rms_px(self) -> float:
        """Root mean square distance between model and measurement, px."""
        return float(np.sqrt(np.mean(np.sum(self.residuals**2, axis=1))))

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
    """The camera with no more numbers than the points (N, 3) and pixels (N, 2) ask for; and why, in words."""
    enough = 2 * len(points) >= NUMBERS + SPARE_NUMBERS

    def refit(chosen: Resection, free: tuple[int, ...]) -> Resection:
        return fit_camera(points, pixels, chosen.camera, free)

    fullest = fit_camera(points, pixels, start, (*BASE, ASPECT, K1, K2) if enough else (*BASE, ASPECT))
    return choose_model(fullest, refit, lambda chosen: folds(chosen.camera, points))


def folds(camera: PhysicalCamera, points: Array) -> bool:
    """Whether the lens turns the picture back on itself among the points: a distortion that cannot be real."""
    in_camera = camera.to_camera(points)
    return camera.lens.folds_within(float(np.max(np.linalg.norm(in_camera[:, :2] / in_camera[:, 2:], axis=1))))
