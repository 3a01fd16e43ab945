"""How much more likely each pixel shows the arm than the rest: log ratios from the arm's colour and the room."""

import math

import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from local_site.kernels.compiled import compiled
from local_site.tracking.foreground.arm_colour import (
    BRIGHTNESS_STEP,
    CHROMA_STEP,
    DARK,
    Table,
    bin_of,
    chromaticity,
)
from local_site.tracking.foreground.room import Levels, Mask

MOST = 4.0  # the log ratio that one pixel may have: none decides alone
UNSEEN = 1e-5  # the share of a colour that was never counted
MOVING = 0.1  # of the pixels do not show the room as it was
LOG_MOVING = math.log(MOVING)
CHROMA_NOISE = 4.0  # of the sum of channels
CHROMA_FLOOR = 0.006
STEADY = 0.7  # of the pixels are as bright as before, the others in shadow or light
BRIGHTNESS_NOISE, BRIGHTNESS_SPREAD = 9.0, 0.04
DARKEST, BRIGHTEST = 0.4, 1.2

LogRatios = NDArray[np.float32]
Tables = tuple[Table, Table, Table]


@compiled
def log_ratio(
    colour: tuple[float, float, float], behind: tuple[float, float, float], known: bool, tables: Tables
) -> float:
    """The log ratio of one colour (blue, green, red), in front of what is behind it, if that is known."""
    arm, rest, unseen = tables
    brightness = colour[0] + colour[1] + colour[2]
    red, green = chromaticity(colour[0], colour[1], colour[2])
    number = bin_of(red, green, brightness)
    if not known:
        return float(unseen[number])
    of_room = _of_room(red, green, brightness, behind)
    if of_room == 0.0:
        return min(float(unseen[number]) - LOG_MOVING, MOST)
    of_rest = MOVING * rest[number] + (1.0 - MOVING) * of_room
    ratio = math.log((arm[number] + UNSEEN) / (of_rest + UNSEEN))
    return min(max(ratio, -MOST), MOST)


def ratio_tables(arm: Table, rest: Table) -> Tables:
    """The shares of the colours on the arm and elsewhere, and their log ratios where the room is not known."""
    unseen = np.log((arm + UNSEEN) / (rest + UNSEEN))
    return arm, rest, np.asarray(np.clip(unseen, -MOST, MOST), np.float32)


@compiled
def _of_room(red: float, green: float, brightness: float, behind: tuple[float, float, float]) -> float:
    """The share of a colour's bin where the room has the colour `behind`, as bright as it was or in shadow or light."""
    before = behind[0] + behind[1] + behind[2]
    r, g = chromaticity(behind[0], behind[1], behind[2])
    sigma = CHROMA_FLOOR + CHROMA_NOISE / (brightness + DARK)
    square = ((red - r) ** 2 + (green - g) ** 2) / sigma**2
    if square > 30.0:
        return 0.0
    of_colour = min(CHROMA_STEP**2 / (2.0 * math.pi * sigma**2), 1.0) * math.exp(-0.5 * square)
    spread = BRIGHTNESS_NOISE + BRIGHTNESS_SPREAD * before
    off = (brightness - before) / spread
    steady = min(BRIGHTNESS_STEP / (2.5 * spread), 1.0) * math.exp(-0.5 * off * off)
    shaded = 0.0
    if DARKEST * before < brightness < BRIGHTEST * before:
        shaded = min(BRIGHTNESS_STEP / ((BRIGHTEST - DARKEST) * before + 1.0), 1.0)
    return of_colour * (STEADY * steady + (1.0 - STEADY) * shaded)


@compiled
def log_ratios(colours: Image, behind: Levels, known: Mask, tables: Tables) -> LogRatios:
    """Log ratios (h, w) of colours (h, w, 3), in front of what is behind them (h, w, 3) where that is known (h, w)."""
    ratios = np.empty(known.shape, np.float32)
    for j in range(known.shape[0]):
        for i in range(known.shape[1]):
            colour = (float(colours[j, i, 0]), float(colours[j, i, 1]), float(colours[j, i, 2]))
            back = (float(behind[j, i, 0]), float(behind[j, i, 1]), float(behind[j, i, 2]))
            ratios[j, i] = log_ratio(colour, back, known[j, i] > 0, tables)
    return ratios
