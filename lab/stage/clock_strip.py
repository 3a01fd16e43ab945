"""A machine-readable clock in a picture, to measure how old it is: black and white cells along its top.

The strip has 44 cells over the whole width: white, black; the milliseconds in 32 bits, highest first; a checksum of
8 bits; black, white. So it is found in a picture of any size, and is not seen in a picture without one.
"""

import zlib

import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.clock import NS_PER_MS

MS_BYTES = 4
WRAP_MS = 1 << 8 * MS_BYTES
HEAD, TAIL = (True, False), (False, True)
CELLS = len(HEAD) + 8 * (MS_BYTES + 1) + len(TAIL)
HEIGHT_FRACTION = 1 / 20
BLACK, WHITE = 0, 255
CLEARLY_BLACK, CLEARLY_WHITE = 90.0, 165.0


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
    cells = levels >= CLEARLY_WHITE
    ms = int.from_bytes(np.packbits(cells[len(HEAD) : -len(TAIL)]).tobytes()[:MS_BYTES], "big")
    return ms if np.array_equal(cells, _cells(ms)) else None


def _height(image: Image) -> int:
    return max(1, round(int(image.shape[0]) * HEIGHT_FRACTION))


def _cells(ms: int) -> NDArray[np.bool_]:
    """The cells that show a time, its checksum included."""
    data = ms.to_bytes(MS_BYTES, "big")
    bits = np.unpackbits(np.frombuffer(data + bytes([zlib.crc32(data) & 0xFF]), dtype=np.uint8))
    return np.concatenate([HEAD, bits.astype(bool), TAIL])
