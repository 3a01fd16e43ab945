"""Strength of the colour that the operator looks for, pixel by pixel: the same in light and in shade."""

from collections.abc import Callable, Mapping

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array

Colour = Callable[[Array, Array, Array], Array]
DARK = 20.0  # added to the brightness: what is nearly black has no colour
WHITE_SPREAD = 60.0


def _blue(b: Array, g: Array, r: Array) -> Array:
    return (b - r) / (b + g + r + DARK)


def _orange(b: Array, g: Array, r: Array) -> Array:
    return np.minimum(r - g, g - b) / (b + g + r + DARK)


def _red(b: Array, g: Array, r: Array) -> Array:
    return (r - np.maximum(b, g)) / (b + g + r + DARK)


def _white(b: Array, g: Array, r: Array) -> Array:
    least, most = np.minimum(np.minimum(b, g), r), np.maximum(np.maximum(b, g), r)
    luma = 0.114 * b + 0.587 * g + 0.299 * r  # sharper than the colours, which JPEG keeps at half the size
    return (luma - np.maximum(most - least - WHITE_SPREAD, 0.0)) / 255.0


# By the colour's name: its measure, and the value half-way between the thing and what lies around it.
COLOURS: Mapping[str, tuple[Colour, float]] = {
    "blue": (_blue, 0.16),
    "orange": (_orange, 0.15),
    "red": (_red, 0.30),
    "white": (_white, 0.69),
}


def colour_above(picture: Image, name: str) -> Array:
    """By how much each pixel of a picture (H, W, 3) is above the colour's threshold (H, W); negative elsewhere."""
    measure, threshold = COLOURS[name]
    b, g, r = np.array(cv2.split(picture), dtype=np.float32)
    return np.asarray(measure(b, g, r) - threshold)
