"""Pictures: conversion between grey and colour, and levels between pixels for compiled loops."""

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled

Levels = NDArray[np.float32]


def as_grey(picture: Image) -> Image:
    """The picture (H, W) in grey."""
    return picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def as_colour(picture: Image) -> Image:
    """The picture (H, W, 3) in BGR."""
    return picture if picture.ndim == 3 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR), dtype=np.uint8)


@compiled
def level_at(picture: Image | Levels, x: float, y: float) -> float:
    """The picture's level at a position in px, interpolated bilinearly; the position must be inside."""
    i, j = int(x), int(y)
    u, v = x - i, y - j
    above = (1.0 - u) * picture[j, i] + u * picture[j, i + 1]
    below = (1.0 - u) * picture[j + 1, i] + u * picture[j + 1, i + 1]
    return float((1.0 - v) * above + v * below)


@compiled
def grey_at(picture: Image | Levels, x: float, y: float) -> float:
    """As `level_at`; a position beyond the border takes the border's level."""
    height, width = picture.shape
    return level_at(picture, min(max(x, 0.0), width - 1.001), min(max(y, 0.0), height - 1.001))


@compiled
def greys_at(picture: Image | Levels, x: Array, y: Array) -> Array:
    """As `grey_at`, at positions (N,)."""
    levels = np.empty(len(x))
    for n in range(len(x)):
        levels[n] = grey_at(picture, x[n], y[n])
    return levels
