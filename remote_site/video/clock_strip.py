"""A clock in a picture that machines read, to measure how old it is: black and white cells along its top. Pure.

The strip has 44 cells over the whole width: white, black; the milliseconds in 32 bits, highest first; a checksum of
8 bits; black, white. So it is found in a picture of any size, and a picture without one is told from one with it.
"""

import zlib

import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.clock import NS_PER_MS

MS_BITS, CHECK_BITS = 32, 8
WRAP_MS = 1 << MS_BITS
HEAD, TAIL = (True, False), (False, True)
CELLS = len(HEAD) + MS_BITS + CHECK_BITS + len(TAIL)
HEIGHT_SHARE = 1 / 20
BLACK, WHITE = 0, 255
CLEARLY_BLACK, CLEARLY_WHITE = 90.0, 165.0

Bits = NDArray[np.bool_]


def draw_clock(image: Image, t_ns: int) -> None:
    """Draw the milliseconds of a time over the upper edge of a picture (H, W) or (H, W, 3), in place."""
    cells = np.where(_cells(t_ns // NS_PER_MS % WRAP_MS), WHITE, BLACK).astype(np.uint8)
    width = image.shape[1]
    row = cells[np.arange(width) * CELLS // width]
    image[: _height(image)] = row if image.ndim == 2 else row[:, None]


def read_clock(image: Image) -> int | None:
    """The milliseconds, modulo 2**32, in a picture (H, W) or (H, W, 3) of any size; None where no clock is read.

    The middle of each cell counts, so that what JPEG and scaling do to the edges does not matter.
    """
    grey = image if image.ndim == 2 else image.mean(axis=2)
    height, width = _height(image), image.shape[1]
    middle = grey[height // 4 : max(height // 4 + 1, height * 3 // 4)].mean(axis=0)
    edges = np.arange(CELLS) * width / CELLS
    first = np.ceil(edges + 0.25 * width / CELLS).astype(int)
    last = np.maximum(first + 1, np.floor(edges + 0.75 * width / CELLS).astype(int))
    if last[-1] > width:
        return None
    levels = np.array([middle[a:b].mean() for a, b in zip(first, last, strict=True)])
    if np.any((levels > CLEARLY_BLACK) & (levels < CLEARLY_WHITE)):
        return None
    return _value(levels >= CLEARLY_WHITE)


def _height(image: Image) -> int:
    return max(1, round(int(image.shape[0]) * HEIGHT_SHARE))


def _cells(ms: int) -> Bits:
    return np.concatenate([HEAD, _bits(ms, MS_BITS), _bits(_check(ms), CHECK_BITS), TAIL])


def _value(cells: Bits) -> int | None:
    """The milliseconds that the cells say; None where frame or checksum are wrong."""
    ms = int("".join("01"[int(cell)] for cell in cells[len(HEAD) : len(HEAD) + MS_BITS]), 2)
    return ms if np.array_equal(cells, _cells(ms)) else None


def _bits(value: int, count: int) -> Bits:
    return np.array([bool(value >> k & 1) for k in reversed(range(count))])


def _check(ms: int) -> int:
    return zlib.crc32(ms.to_bytes(4, "big")) & 0xFF
