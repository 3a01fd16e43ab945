"""How much more likely each pixel shows the arm than the rest: log ratios from the arm's colour and the room.

Colours are in planes, and the loops free of calls and jumps: the compiler then takes many at once.
"""

import math

import numpy as np
from numpy.typing import NDArray

from local_site.kernels.compiled import compiled
from local_site.tracking.foreground.arm_colour import (
    BRIGHTNESS_STEP,
    CHROMA_STEP,
    DARK,
    Table,
    bin_of,
    chromaticity,
)
from local_site.tracking.foreground.room import ColourPlanes, Mask, Planes

MOST = 4.0  # the log ratio that one pixel may have: none decides alone
UNSEEN = 1e-5  # the share of a colour that was never counted
MOVING = 0.1  # of the pixels do not show the room as it was
LOG_MOVING = math.log(MOVING)
CHROMA_NOISE = 4.0  # of the sum of channels
CHROMA_FLOOR = 0.006
STEADY = 0.7  # of the pixels are as bright as before, the others in shadow or light
BRIGHTNESS_NOISE, BRIGHTNESS_SPREAD = 9.0, 0.04
DARKEST, BRIGHTEST = 0.4, 1.2
FARTHEST = 30.0  # in squared standard deviations: beyond it a colour is not the room's
LEAST_EXPONENT = -80.0

LogRatios = NDArray[np.float32]
Bins = NDArray[np.int32]
Tables = tuple[Table, Table, Table]


def ratio_tables(arm: Table, rest: Table) -> Tables:
    """The logarithms of the colours' shares on the arm, their shares elsewhere, and their log ratios where the room is
    not known."""
    log_arm = np.log(arm + np.float32(UNSEEN))
    unseen = log_arm - np.log(rest + np.float32(UNSEEN))
    return log_arm, rest, np.asarray(np.clip(unseen, -MOST, MOST), np.float32)


def log_ratios(colours: ColourPlanes, behind: Planes, known: Mask, tables: Tables) -> LogRatios:
    """Log ratios (...) of colours (3, ...), in front of what is behind them (3, ...) where that is known (...)."""
    bins, of_colour, shares = _compared(colours.reshape(3, -1), behind.reshape(3, -1))
    np.exp(of_colour, out=of_colour)
    np.exp(shares[0], out=shares[0])
    of_room = _of_room(of_colour, shares)
    of_rest = _of_rest(of_room, bins, tables[1])
    np.log(of_rest, out=of_rest)
    return _limited(of_rest, of_room, known.reshape(-1), bins, tables).reshape(known.shape)


@compiled
def _compared(colours: ColourPlanes, behind: Planes) -> tuple[Bins, LogRatios, Planes]:
    """By pixel: the colour's bin; the exponent of how near its chromaticity is to that of what is behind; and the
    exponent of how near its brightness is, with the factors of that, of shaded pixels, and of both."""
    blue, green, red = colours[0], colours[1], colours[2]
    back_blue, back_green, back_red = behind[0], behind[1], behind[2]
    bins, of_colour = np.empty(len(blue), np.int32), np.empty(len(blue), np.float32)
    shares = np.empty((4, len(blue)), np.float32)
    steady, of_steady, of_shaded, of_both = shares[0], shares[1], shares[2], shares[3]
    for n in range(len(blue)):
        brightness = float(blue[n]) + float(green[n]) + float(red[n])
        before = back_blue[n] + back_green[n] + back_red[n]
        r, g = chromaticity(blue[n], green[n], red[n])
        back_r, back_g = chromaticity(back_blue[n], back_green[n], back_red[n])
        bins[n] = bin_of(r, g, brightness)
        sigma = CHROMA_FLOOR + CHROMA_NOISE / (brightness + DARK)
        square = ((r - back_r) ** 2 + (g - back_g) ** 2) / (sigma * sigma)
        of_colour[n] = max(-0.5 * square, LEAST_EXPONENT)
        within = 1.0 if square <= FARTHEST else 0.0
        of_both[n] = within * min(CHROMA_STEP**2 / (2.0 * math.pi * sigma * sigma), 1.0)
        spread = BRIGHTNESS_NOISE + BRIGHTNESS_SPREAD * before
        off = (brightness - before) / spread
        steady[n] = max(-0.5 * off * off, LEAST_EXPONENT)
        of_steady[n] = STEADY * min(BRIGHTNESS_STEP / (2.5 * spread), 1.0)
        is_shaded = (brightness > DARKEST * before) & (brightness < BRIGHTEST * before)
        shaded = (1.0 - STEADY) * min(BRIGHTNESS_STEP / ((BRIGHTEST - DARKEST) * before + 1.0), 1.0)
        of_shaded[n] = shaded if is_shaded else 0.0
    return bins, of_colour, shares


@compiled
def _of_room(near: LogRatios, shares: Planes) -> LogRatios:
    """The share of each colour's bin in the room: the colour behind, as bright as it was or in shadow or light."""
    steady, of_steady, of_shaded, of_both = shares[0], shares[1], shares[2], shares[3]
    of_room: LogRatios = of_both * near * (of_steady * steady + of_shaded)
    return of_room


@compiled
def _of_rest(of_room: LogRatios, bins: Bins, rest: Table) -> LogRatios:
    """The share of each colour's bin in the rest: the room as it was, or what moves before it."""
    of_rest = np.empty_like(of_room)
    for n in range(len(bins)):
        of_rest[n] = MOVING * rest[bins[n]] + (1.0 - MOVING) * of_room[n] + UNSEEN
    return of_rest


@compiled
def _limited(log_rest: LogRatios, of_room: LogRatios, known: Mask, bins: Bins, tables: Tables) -> LogRatios:
    """The log ratios, limited to what one pixel may have."""
    log_arm, _, unseen = tables
    ratios = np.empty_like(log_rest)
    for n in range(len(bins)):
        moving = unseen[bins[n]] - LOG_MOVING
        ratio = log_arm[bins[n]] - log_rest[n] if of_room[n] > 0.0 else moving
        ratios[n] = min(max(ratio, -MOST), MOST) if known[n] > 0 else unseen[bins[n]]
    return ratios
