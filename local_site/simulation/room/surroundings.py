"""Pictures of wall and floor, (H, W, 4) BGR and cover: paint, a door, posters, shadows; carpet; boards of wood."""

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image

Field = NDArray[np.float32]
Colour = tuple[int, int, int]

PAINTS: tuple[Colour, ...] = ((206, 212, 214), (188, 204, 216), (208, 206, 192), (186, 190, 196), (176, 198, 190))
INKS: tuple[Colour, ...] = ((150, 84, 36), (52, 60, 168), (70, 120, 50), (60, 60, 60), (40, 140, 205))
CARPETS: tuple[Colour, ...] = ((108, 98, 90), (92, 96, 104), (110, 100, 78))
WOODS = ((112, 150, 198), (96, 132, 186), (124, 164, 210))  # of skin's colours
BOARD_M = 0.14
PAPER: Colour = (232, 236, 238)


def opaque(picture: NDArray[np.floating] | Image) -> Image:
    """A picture (H, W, 3) that covers all that is behind it."""
    return np.dstack([np.clip(picture, 0, 255).astype(np.uint8), np.full(picture.shape[:2], 255, np.uint8)])


def clouds(random: np.random.Generator, shape: tuple[int, int], cell_px: float) -> Field:
    """Smooth noise (H, W) of about unit deviation whose features are `cell_px` large."""
    cells = tuple(max(2, round(size / cell_px) + 2) for size in shape)
    grid = random.standard_normal(cells, dtype=np.float32)
    return np.asarray(cv2.resize(grid, shape[::-1], interpolation=cv2.INTER_CUBIC), dtype=np.float32)


def wall(random: np.random.Generator, px_per_m: float, width_m: float, height_m: float) -> Image:
    """A painted wall with a door, posters, a skirting board and a socket, lit unevenly."""
    height, width = round(height_m * px_per_m), round(width_m * px_per_m)
    picture = np.full((height, width, 3), PAINTS[random.integers(len(PAINTS))], np.uint8)
    cv2.rectangle(picture, (0, height - round(0.09 * px_per_m)), (width, height), (222, 226, 228), -1)
    _door(picture, round(random.choice([0.16, 0.80]) * width), px_per_m)
    for k in range(3):
        left = round((0.31 + 0.16 * k + random.uniform(-0.03, 0.03)) * width)
        top = round(random.uniform(0.20, 0.30) * height)
        sheet = poster(random, round(random.uniform(0.32, 0.5) * px_per_m))
        hang(picture, sheet, left, top)
    socket = (round(0.47 * width), round(0.86 * height))
    cv2.rectangle(picture, socket, (socket[0] + 26, socket[1] + 26), (236, 238, 238), -1)
    cv2.circle(picture, (socket[0] + 13, socket[1] + 13), 8, (200, 204, 206), -1, cv2.LINE_AA)
    light = 0.93 + 0.05 * clouds(random, (height, width), 1.3 * px_per_m) + 0.006 * clouds(random, (height, width), 2.0)
    light *= np.linspace(1.06, 0.80, height, dtype=np.float32)[:, None]
    return opaque(picture * light[:, :, None])


def floor(random: np.random.Generator, px_per_m: float, width_m: float, deep_m: float) -> Image:
    """Carpet tiles."""
    shape = round(deep_m * px_per_m), round(width_m * px_per_m)
    tile = round(0.5 * px_per_m)
    rows, columns = np.indices(shape) // tile
    shades = 1.0 + 0.05 * random.standard_normal((rows.max() + 1, columns.max() + 1), dtype=np.float32)
    level = shades[rows, columns] + np.float32(0.05) * random.standard_normal(shape, dtype=np.float32)
    return opaque(level[:, :, None] * np.array(CARPETS[random.integers(len(CARPETS))], np.float32))


def wood(random: np.random.Generator, px_per_m: float, width_m: float, height_m: float) -> Image:
    """Upright boards with grain, in the colours of skin."""
    shape = round(height_m * px_per_m), round(width_m * px_per_m)
    column = np.arange(shape[1])
    board = column // round(BOARD_M * px_per_m)
    shades = np.array(WOODS)[random.integers(len(WOODS), size=board.max() + 1)] * random.uniform(
        0.86, 1.04, (board.max() + 1, 1)
    )
    grain = clouds(random, (shape[0] // 16 + 1, shape[1]), 4.0).repeat(16, axis=0)[: shape[0]]
    level = 1.0 + 0.05 * grain + 0.03 * clouds(random, shape, 60.0)
    level[:, column % round(BOARD_M * px_per_m) < 2] *= 0.6
    return opaque(level[:, :, None] * shades[board])


def poster(random: np.random.Generator, width: int) -> Image:
    """A sheet (H, W, 3) with a coloured head, shapes and lines of text."""
    height = round(1.4 * width)
    sheet = np.full((height, width, 3), PAPER, np.uint8)
    ink = INKS[random.integers(len(INKS))]
    cv2.rectangle(sheet, (0, 0), (width, round(0.18 * height)), ink, -1)
    for _ in range(4):
        at = random.uniform((0.15, 0.28), (0.85, 0.55)) * (width, height)
        axes = np.rint(random.uniform(0.06, 0.2, 2) * width).astype(int).tolist()
        shade = tuple(int(c) for c in random.integers(60, 220, 3))
        cv2.ellipse(
            sheet, np.rint(at).astype(int).tolist(), axes, random.uniform(0, 180), 0, 360, shade, -1, cv2.LINE_AA
        )
    for row in range(round(0.64 * height), round(0.94 * height), 6):
        end = round(random.uniform(0.55, 0.92) * width)
        cv2.line(sheet, (round(0.08 * width), row), (end, row), (120, 120, 120), 2)
    return sheet


def hang(picture: Image, sheet: Image, left: int, top: int) -> None:
    """Put a sheet on a wall (H, W, 3), with its soft shadow."""
    height, width = sheet.shape[:2]
    shadow = np.zeros(picture.shape[:2], np.float32)
    shadow[top + 4 : top + height + 6, left - 6 : left + width - 2] = 0.3
    shadow = np.asarray(cv2.GaussianBlur(shadow, (0, 0), 4.0), np.float32)
    picture[:] = (picture * (1.0 - shadow[:, :, None])).astype(np.uint8)
    picture[top : top + height, left : left + width] = sheet


def _door(picture: Image, middle: int, px_per_m: float) -> None:
    half, top = round(0.48 * px_per_m), 0
    bottom = picture.shape[0]
    frame, leaf, groove = (150, 156, 158), (178, 190, 198), (140, 150, 156)
    cv2.rectangle(picture, (middle - half, top), (middle + half, bottom), frame, -1)
    inner = half - round(0.07 * px_per_m)
    cv2.rectangle(picture, (middle - inner, top), (middle + inner, bottom), leaf, -1)
    edge = round(0.14 * px_per_m)
    for low, high in ((0.05, 0.45), (0.55, 0.93)):
        corners = (middle - inner + edge, round(low * bottom)), (middle + inner - edge, round(high * bottom))
        cv2.rectangle(picture, *corners, groove, 3, cv2.LINE_AA)
    handle = middle - inner + edge // 2, round(0.5 * bottom)
    cv2.line(picture, handle, (handle[0] + edge // 2 + 12, handle[1]), (110, 112, 114), 9, cv2.LINE_AA)
