"""Resection: one camera from control points, with no more numbers than the points speak for."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeVar

import numpy as np
from scipy.optimize import least_squares
from scipy.special import fdtrc

from common.geometry import Array
from local_site.calibration.physical_camera import ASPECT, BASE, K1, K2, NUMBERS, PhysicalCamera

SIGNIFICANCE = 0.01
ROUNDING_PX = 1e-4
LENS_WORDS = {(): "no distortion", (K1,): "k1", (K1, K2): "k1 and k2"}


class CameraFit(Protocol):
    """A fit: which camera numbers were free, its residuals in px, how many numbers were fitted in all."""

    @property
    def free(self) -> tuple[int, ...]: ...
    @property
    def residuals(self) -> Array: ...
    @property
    def numbers(self) -> int: ...


F = TypeVar("F", bound=CameraFit)


def choose_model(fullest: F, refit: Callable[[F, tuple[int, ...]], F], unreal: Callable[[F], bool]) -> tuple[F, str]:
    """The simplest fit that costs no more than noise would, and why, in words.

    From the fullest fit on, fy apart from fx, then k2, then k1 are left out, each where an F-test at 1 % does not tell
    the loss from noise, or where the richer fit is `unreal`.
    """
    chosen, chances = fullest, []
    for number in (ASPECT, K2, K1):
        if number not in chosen.free or (number == K1 and K2 in chosen.free):
            continue
        simple = refit(chosen, tuple(n for n in chosen.free if n != number))
        chance = chance_of_noise(simple, chosen)
        if number != ASPECT:
            chances.append(f"{'k1' if number == K1 else 'k2'} p = {chance:.2g}")
        if chance >= SIGNIFICANCE or unreal(chosen):
            chosen = simple
    lens = LENS_WORDS[tuple(n for n in chosen.free if n >= K1)]
    pixel = "square pixels" if ASPECT not in chosen.free else "fx apart from fy"
    return chosen, f"{lens}, {pixel} (F-test at 1 %: {', '.join(chances) or 'too few points'})"


def chance_of_noise(simple: CameraFit, rich: CameraFit) -> float:
    """How probably noise alone would let the richer model fit as much better as it does (F-test)."""
    added = rich.numbers - simple.numbers
    count = rich.residuals.size
    freedom = count - rich.numbers
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
