"""Pictures of materials, drawn from a random generator: wood, terrazzo, painted blocks, cloth, metal, cardboard.

A picture is (H, W, 3) float32, RGB, 0 to 1, its top row first. Nothing here knows of light: that is baked in later.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array

Picture = NDArray[np.float32]
Field = NDArray[np.float32]
Colour = tuple[float, float, float]

FINE_PX, CELLS = 512, 300
STAVE_M = 0.062
STAVE_LENGTH_M = 0.55
CHIP_M = 0.009
BLOCK_M = (0.40, 0.20)
JOINT_M = 0.010
CHECK_M = 0.034
OAK: Colour = (0.70, 0.575, 0.45)
PAINT: Colour = (0.77, 0.79, 0.765)
CHECKS = np.array([(0.86, 0.84, 0.77), (0.58, 0.63, 0.53), (0.30, 0.40, 0.31)], dtype=np.float32)
TERRAZZO: tuple[Colour, ...] = (  # cement, then the stones
    (0.60, 0.60, 0.58),
    (0.75, 0.73, 0.69),
    (0.38, 0.38, 0.38),
    (0.57, 0.52, 0.47),
    (0.84, 0.83, 0.80),
)


def rgb(colour: Colour) -> Field:
    """A colour to reckon with (3,)."""
    return np.array(colour, dtype=np.float32)


def plain(shape: tuple[int, int], colour: Colour) -> Picture:
    """A picture of one colour."""
    return np.full((*shape, 3), colour, dtype=np.float32)


def tinted(factor: Field, colour: Colour) -> Picture:
    """A picture of one colour times a factor (H, W), cut off at white."""
    return _field(cv2.merge([np.minimum(factor * np.float32(part), np.float32(1.0)) for part in colour]))


def shaded(picture: Picture, factor: Field) -> Picture:
    """The picture times a factor (H, W), cut off at white."""
    return _field(np.minimum(cv2.multiply(picture, cv2.merge([factor] * 3)), np.float32(1.0)))


def noise(rng: np.random.Generator, shape: tuple[int, int], cell_px: tuple[float, float]) -> Field:
    """Smooth noise (H, W) of zero mean and about unit deviation, its features `cell_px` (rows, columns) large.

    Noise so fine that nobody can see it repeat is drawn once and laid side by side.
    """
    part = tuple(min(size, max(FINE_PX, round(CELLS * cell))) for size, cell in zip(shape, cell_px, strict=True))
    cells = tuple(max(2, round(size / cell) + 2) for size, cell in zip(part, cell_px, strict=True))
    grid = rng.standard_normal(cells, dtype=np.float32)
    tile = cv2.resize(grid, part[::-1], interpolation=cv2.INTER_CUBIC)
    times = [-(-size // once) for size, once in zip(shape, part, strict=True)]
    return _field(np.tile(tile, times)[: shape[0], : shape[1]])


def cloudy(rng: np.random.Generator, shape: tuple[int, int], largest_px: float, octaves: int = 4) -> Field:
    """Noise (H, W) of several sizes, each half as large and two thirds as strong as the one before."""
    total = np.zeros(shape, dtype=np.float32)
    for k in range(octaves):
        total += noise(rng, shape, (largest_px / 2**k,) * 2) * np.float32(0.66**k)
    return total / np.float32(1.5)


def relief(height: Field, strength: float) -> Field:
    """The shading (H, W) around 1 of a surface of this height that is lit from its upper right."""
    shading = np.ones_like(height)
    shading[1:, :-1] -= np.float32(strength) * (height[1:, :-1] - height[:-1, 1:])
    return shading


def wood(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    """Oak, glued from staves that run along the picture's rows."""
    height, width = shape
    rows = (np.arange(height) / (STAVE_M * px_m)).astype(int)
    offsets = rng.uniform(0.0, 1.0, rows.max() + 1)
    lengths = (np.arange(width)[None, :] / (STAVE_LENGTH_M * px_m) + offsets[rows][:, None]).astype(int)
    tones = _field(rng.normal(1.0, 0.05, (rows.max() + 1, lengths.max() + 1)))
    shift = _field(rng.uniform(0.0, 40.0, tones.shape))
    staves = rows[:, None], lengths
    rings = 3.2 * noise(rng, shape, (0.03 * px_m, 0.25 * px_m)) + shift[staves]
    rings += _field(np.arange(height)[:, None] / px_m * 900.0)
    fibres = noise(rng, shape, (1.0, 0.03 * px_m)) + 0.7 * noise(rng, shape, (2.5, 0.09 * px_m))
    factor = tones[staves] + 0.045 * np.sin(rings) + 0.04 * fibres
    factor -= 0.16 * (noise(rng, shape, (1.0, 0.012 * px_m)) > 1.75)
    factor[1:][rows[1:] != rows[:-1]] -= 0.20
    factor[:, 1:][lengths[:, 1:] != lengths[:, :-1]] -= 0.20
    return tinted(factor, OAK)


def terrazzo(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    """A polished floor of stone chips in cement, with joints every metre."""
    stones = np.zeros(shape, dtype=np.uint8)
    for k, threshold in enumerate((1.0, 1.1, 1.15, 1.25), start=1):
        cell = CHIP_M * px_m * rng.uniform(0.7, 1.2)
        stones[noise(rng, shape, (cell, cell)) > threshold] = k
    colours = np.zeros((256, 1, 3), dtype=np.float32)
    colours[: len(TERRAZZO), 0] = TERRAZZO
    floor = _field(cv2.LUT(cv2.merge([stones] * 3), colours))
    floor = shaded(floor, np.float32(1.0) + np.float32(0.03) * cloudy(rng, shape, 0.5 * px_m))
    for axis in (0, 1):
        for k in range(int(shape[axis] / px_m) + 1):
            at = round((k + 0.6) * px_m)
            line = (slice(at, at + 2), slice(None)) if axis == 0 else (slice(None), slice(at, at + 2))
            floor[line] = (0.44, 0.42, 0.38)
    return floor


def painted_blocks(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    """A wall of painted concrete blocks, rough, in running bond."""
    height, width = shape
    across, up = np.arange(width) / px_m, (height - np.arange(height)) / px_m
    course = (up / BLOCK_M[1]).astype(int)
    along = across + np.array([[0.0], [BLOCK_M[0] / 2]])  # of even and odd courses
    bed, heads = _field(_to_joint(up, BLOCK_M[1])), _field(_to_joint(along, BLOCK_M[0]))
    depth = np.minimum(np.minimum(bed[:, None], heads[course % 2]), np.float32(1.0))
    columns = (along / BLOCK_M[0]).astype(int)
    tones = _field(rng.normal(1.0, 0.018, (course.max() + 1, columns.max() + 1)))
    rough = noise(rng, shape, (1.6, 1.6)) + np.float32(0.8) * noise(rng, shape, (4.0, 4.0))
    factor = relief(np.float32(1.1) * depth + np.float32(0.24) * rough, 0.19)
    factor *= tones[course[:, None], columns[course % 2]] * (np.float32(0.88) + np.float32(0.12) * depth)
    return tinted(factor, PAINT)


def printed_cloth(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    """A checked cloth with a printed motif in every light check, woven, hemmed and a little creased."""
    height, width = shape
    check = CHECK_M * px_m
    rows, columns = np.arange(height) / check, np.arange(width) / check
    dark = (rows.astype(int) % 2)[:, None] + (columns.astype(int) % 2)[None, :]
    cloth = CHECKS[dark]
    v, u = (rows % 1.0 - 0.5)[:, None], (columns % 1.0 - 0.5)[None, :]
    radius, angle = np.hypot(u, v), np.arctan2(v, u)
    petal = (radius < 0.20 + 0.12 * np.cos(5.0 * angle)) & (dark == 0)
    cloth[petal] = (0.50, 0.36, 0.42)
    cloth[(radius < 0.09) & (dark == 0)] = (0.78, 0.72, 0.55)
    weave = 0.06 * ((np.arange(height)[:, None] + np.arange(width)[None, :]) % 2 - 0.5)
    creases = 0.07 * noise(rng, shape, (0.10 * px_m, 0.16 * px_m))
    hem = np.ones(shape, dtype=np.float32)
    for edge in (slice(6, 8), slice(-8, -6)):
        hem[edge, ::3], hem[::3, edge] = 0.72, 0.72
    return shaded(cloth, _field((1.0 + weave + creases + 0.03 * rng.standard_normal(shape, dtype=np.float32)) * hem))


def painted_metal(rng: np.random.Generator, shape: tuple[int, int], colour: Colour) -> Picture:
    """Enamel with the fine texture of a spray gun, darker and worn at the edges."""
    height, width = shape
    to_edge = np.minimum(
        np.minimum(np.arange(height), np.arange(height)[::-1])[:, None],
        np.minimum(np.arange(width), np.arange(width)[::-1])[None, :],
    )
    edge = np.exp(-to_edge / np.float32(0.05 * min(shape)))
    peel = relief(noise(rng, shape, (2.0, 2.0)), 0.022)
    grime = 0.05 * cloudy(rng, shape, 0.6 * min(shape), 3)
    return tinted(_field((1.0 - 0.14 * edge + grime * (0.4 + edge)) * peel), colour)


def cardboard(rng: np.random.Generator, shape: tuple[int, int]) -> Picture:
    """Corrugated board: faint upright flutes, spots, soiled edges."""
    flutes = 0.018 * np.sin(np.arange(shape[1]) * 2.1)[None, :]
    spots = 0.04 * noise(rng, shape, (1.0, 1.5)) + 0.03 * cloudy(rng, shape, 60.0, 3)
    return tinted(_field(1.0 + flutes + spots), (0.63, 0.53, 0.42))


def _to_joint(at: Array, spacing_m: float) -> Array:
    to_middle = np.abs(at % spacing_m - spacing_m / 2)
    return np.asarray((spacing_m / 2 - to_middle) / JOINT_M, dtype=float)


def _field(array: object) -> Field:
    return np.asarray(array, dtype=np.float32)
