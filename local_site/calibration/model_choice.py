"""The choice of a camera's model: no number is fitted that the residuals do not ask for (F-test)."""

from collections.abc import Callable
from typing import Protocol, TypeVar

import numpy as np
from scipy.special import fdtrc

from common.geometry import Array
from local_site.calibration.physical_camera import ASPECT, K1, K2

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
