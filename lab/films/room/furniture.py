"""Things that stand in rooms, drawn from a random source into a wall's or a desk's picture."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from common.cameras.camera import Image

Colour = Sequence[float]
GREYS = ((60, 60, 62), (140, 142, 145), (205, 207, 210), (35, 38, 42))
SPINES = ((48, 60, 150), (120, 80, 40), (60, 110, 70), (190, 190, 200), (40, 40, 45), (70, 150, 190), (130, 60, 90))
WOOD = (104, 150, 196)  # BGR, of skin's colour


def painted(shape: tuple[int, int], colour: Colour, random: Generator) -> Image:
    """A painted surface (H, W, 3): its colour, unevenly lit and a little rough."""
    height, width = shape
    coarse = random.normal(0.0, 1.0, (6, 9)).astype(np.float32)
    uneven = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    rough = random.normal(0.0, 1.6, shape).astype(np.float32)
    surface = np.array(colour, np.float32) * (1.0 + 0.05 * uneven[..., None]) + rough[..., None]
    return np.clip(surface, 0, 255).astype(np.uint8)


def wooden(shape: tuple[int, int], random: Generator, colour: Colour = WOOD) -> Image:
    """Boards with grain (H, W, 3), lying across."""
    height, width = shape
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    coarse = random.normal(0.0, 1.0, (12, 6)).astype(np.float32)
    warp = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    rings = np.sin(0.16 * y + 3.0 * warp + 0.002 * x) + 0.5 * np.sin(0.41 * y + 5.0 * warp)
    board = (y // (height / 7)).astype(int)
    tint = (1.0 + 0.07 * random.standard_normal(8))[board]
    fine = cv2.GaussianBlur(random.normal(0.0, 9.0, shape).astype(np.float32), (31, 1), 8.0)
    seam = np.where(np.mod(y, height / 7) < 3, 0.6, 1.0)
    grain = tint * seam * (1.0 + 0.06 * rings) + fine / 160.0
    boards = np.array(colour, np.float32) * grain[..., None]
    return np.asarray(np.clip(boards, 0, 255), dtype=np.uint8)


def shelf(wall: Image, left: int, top: int, width: int, height: int, random: Generator) -> None:
    """A shelf with rows of books and boxes, drawn onto a wall."""
    cv2.rectangle(wall, (left, top), (left + width, top + height), (86, 120, 150), -1)
    rows = 3
    for row in range(rows):
        y0, y1 = top + 8 + row * height // rows, top + (row + 1) * height // rows - 6
        cv2.rectangle(wall, (left + 8, y0), (left + width - 8, y1), (44, 56, 66), -1)
        x = left + 12
        while x < left + width - 60:
            thick, tall = int(random.integers(10, 42)), int((y1 - y0) * random.uniform(0.55, 0.95))
            colour = np.array(SPINES[random.integers(len(SPINES))]) * random.uniform(0.7, 1.15)
            cv2.rectangle(wall, (x, y1 - tall), (x + thick, y1), colour.tolist(), -1)
            cv2.rectangle(wall, (x, y1 - tall), (x + thick, y1), (25, 25, 25), 1)
            cv2.line(wall, (x + 4, y1 - tall + 14), (x + thick - 4, y1 - tall + 14), (200, 200, 190), 3)
            x += thick + int(random.integers(0, 16) * (random.random() < 0.3))


def monitor(wall: Image, left: int, top: int, width: int, random: Generator) -> None:
    """A screen with windows and text."""
    height = int(0.58 * width)
    cv2.rectangle(wall, (left - 10, top - 10), (left + width + 10, top + height + 26), (24, 24, 26), -1)
    cv2.rectangle(wall, (left, top), (left + width, top + height), (120, 84, 40), -1)
    for _ in range(3):
        x, y = left + int(random.uniform(0, 0.5) * width), top + int(random.uniform(0, 0.5) * height)
        right, bottom = min(x + width // 2, left + width), min(y + height // 2, top + height)
        cv2.rectangle(wall, (x, y), (right, bottom), (236, 238, 240), -1)
        for line in range(y + 18, bottom - 6, 12):
            end = x + 10 + int(random.uniform(0.2, 0.9) * (right - x - 20))
            cv2.line(wall, (x + 10, line), (end, line), (110, 105, 100), 3)
    cv2.rectangle(
        wall, (left + width // 2 - 30, top + height + 26), (left + width // 2 + 30, top + height + 90), GREYS[0], -1
    )


def window(wall: Image, left: int, top: int, width: int, height: int) -> None:
    """A bright window with bars and a sill."""
    glow = np.linspace(250, 205, height, dtype=np.float32)[:, None, None] * np.array((1.0, 0.98, 0.94), np.float32)
    wall[top : top + height, left : left + width] = np.broadcast_to(glow, (height, width, 3)).astype(np.uint8)
    for k in range(3):
        x = left + k * width // 2
        cv2.line(wall, (x, top), (x, top + height), (225, 228, 230), 14)
    cv2.rectangle(wall, (left - 14, top + height), (left + width + 14, top + height + 22), (190, 195, 200), -1)


def cables(wall: Image, count: int, random: Generator) -> None:
    """Cables that hang and cross."""
    height, width = wall.shape[:2]
    for _ in range(count):
        t = np.linspace(0.0, 1.0, 60)
        knots = np.column_stack([random.uniform(0, width, 4), random.uniform(0.35 * height, height, 4)])
        weights = np.column_stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        line: NDArray[np.int32] = np.rint(weights @ knots).astype(np.int32)
        colour = GREYS[random.integers(len(GREYS))]
        cv2.polylines(wall, [line], False, colour, int(random.integers(4, 11)), cv2.LINE_AA)


def poster(wall: Image, picture: Image, left: int, top: int, width: int) -> None:
    """A picture with a white border."""
    height = round(width * picture.shape[0] / picture.shape[1])
    cv2.rectangle(wall, (left - 12, top - 12), (left + width + 12, top + height + 12), (238, 238, 236), -1)
    wall[top : top + height, left : left + width] = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)


def clutter(desk: Image, count: int, random: Generator) -> None:
    """Papers, boxes and mugs on a desk."""
    height, width = desk.shape[:2]
    for _ in range(count):
        middle = (float(random.uniform(0, width)), float(random.uniform(0, height)))
        sides = (float(random.uniform(50, 150)), float(random.uniform(30, 110)))
        corners = cv2.boxPoints((middle, sides, float(random.uniform(0, 90)))).astype(np.int32)
        colour = GREYS[random.integers(4)] if random.random() < 0.5 else SPINES[random.integers(len(SPINES))]
        cv2.fillPoly(desk, [corners], colour, cv2.LINE_AA)
        if random.random() < 0.4:
            x, y = np.rint(middle).astype(int).tolist()
            cv2.circle(
                desk, (x, y), int(random.integers(12, 26)), SPINES[random.integers(len(SPINES))], -1, cv2.LINE_AA
            )
