"""Pictures of what stands in an office, (H, W, 4) BGR and cover: shelf, cupboard, desk, monitor, books, plant, mug."""

import cv2
import numpy as np

from common.cameras.camera import Image
from local_site.simulation.room.surroundings import INKS, Colour, clouds, opaque

LAMINATES: tuple[Colour, ...] = ((196, 200, 204), (150, 160, 168), (120, 134, 146), (212, 214, 214))
BLACK: Colour = (38, 36, 35)


def shelf(random: np.random.Generator, px_per_m: float, width_m: float, height_m: float) -> Image:
    """Two boards with the backs of books and binders between them."""
    picture = _empty(px_per_m, width_m, height_m)
    height, width = picture.shape[:2]
    board = max(3, round(0.022 * px_per_m))
    for low, high in ((0, height // 2), (height // 2, height)):
        picture[low:high] = (78, 84, 88, 255)
        left = 6
        while left < width - 30:
            wide = int(random.integers(round(0.02 * px_per_m), round(0.08 * px_per_m)))
            top = low + round(random.uniform(0.12, 0.42) * (high - low))
            if random.random() < 0.85:
                _spine(random, picture, (left, top, left + wide - 1, high - board))
            left += wide + 1
        picture[high - board : high] = (168, 176, 182, 255)
    picture[:, :5] = picture[:, -5:] = (150, 158, 164, 255)
    return picture


def cupboard(random: np.random.Generator, px_per_m: float, width_m: float, height_m: float) -> Image:
    """Two doors with handles."""
    shape = round(height_m * px_per_m), round(width_m * px_per_m)
    shade = np.array(LAMINATES[random.integers(len(LAMINATES))]) * 0.9
    picture = opaque((1.0 + 0.015 * clouds(random, shape, 30.0))[:, :, None] * shade)
    middle = shape[1] // 2
    cv2.line(picture, (middle, 0), (middle, shape[0]), (90, 92, 94, 255), 2)
    for x in (middle - 14, middle + 14):
        cv2.line(picture, (x, shape[0] // 5), (x, shape[0] // 5 + 30), (120, 122, 124, 255), 4, cv2.LINE_AA)
    picture[:7] = (220, 222, 222, 255)
    return picture


def desk_top(random: np.random.Generator, px_per_m: float, width_m: float, deep_m: float) -> Image:
    """A board with papers, a keyboard and a shadow below the monitor; its first row is the far edge."""
    shape = round(deep_m * px_per_m), round(width_m * px_per_m)
    shade = np.array(LAMINATES[random.integers(len(LAMINATES))])
    picture = np.asarray((1.0 + 0.02 * clouds(random, shape, 60.0))[:, :, None] * shade, np.float32)
    middle = shape[1] // 2
    shadow = np.zeros(shape, np.float32)
    cv2.ellipse(shadow, (middle, round(0.3 * shape[0])), (round(0.32 * px_per_m), 26), 0, 0, 360, 0.45, -1)
    picture *= 1.0 - cv2.GaussianBlur(shadow, (0, 0), 14.0)[:, :, None]
    for _ in range(3):
        at = random.uniform((0.05, 0.45), (0.95, 0.8)) * shape[::-1]
        box = cv2.boxPoints((at.tolist(), (0.21 * px_per_m, 0.29 * px_per_m), random.uniform(-25, 25)))
        cv2.fillConvexPoly(picture, np.rint(box).astype(np.int32), (230, 234, 234), cv2.LINE_AA)
    keys = middle - round(0.2 * px_per_m), round(0.62 * shape[0])
    cv2.rectangle(picture, keys, (keys[0] + round(0.42 * px_per_m), keys[1] + round(0.13 * px_per_m)), BLACK, -1)
    picture[-4:] *= 0.7
    return opaque(picture)


def drawers(random: np.random.Generator, px_per_m: float, width_m: float, height_m: float) -> Image:
    """Three drawers with handles."""
    shape = round(height_m * px_per_m), round(width_m * px_per_m)
    picture = opaque(np.full((*shape, 3), LAMINATES[random.integers(len(LAMINATES))]) * 0.72)
    for k in range(3):
        top = k * shape[0] // 3
        cv2.rectangle(picture, (2, top + 2), (shape[1] - 3, top + shape[0] // 3 - 3), (96, 100, 104, 255), 2)
        cv2.line(picture, (shape[1] // 3, top + 22), (2 * shape[1] // 3, top + 22), (70, 72, 74, 255), 5, cv2.LINE_AA)
    return picture


def legs(px_per_m: float, width_m: float, height_m: float) -> Image:
    """The edge of a desk's board and two legs."""
    picture = _empty(px_per_m, width_m, height_m)
    leg = round(0.05 * px_per_m)
    for left in (leg, picture.shape[1] - 2 * leg):
        picture[:, left : left + leg] = (88, 90, 92, 255)
    picture[: round(0.03 * px_per_m)] = (128, 132, 136, 255)
    return picture


def monitor(random: np.random.Generator, px_per_m: float, width_m: float, height_m: float) -> Image:
    """A monitor on its foot, with windows of text on the screen."""
    picture = _empty(px_per_m, width_m, height_m)
    height, width = picture.shape[:2]
    low = round(0.76 * height)
    cv2.rectangle(picture, (width // 2 - 12, low), (width // 2 + 12, height - 8), (*BLACK, 255), -1)
    cv2.ellipse(picture, (width // 2, height - 7), (width // 5, 6), 0, 0, 360, (*BLACK, 255), -1, cv2.LINE_AA)
    cv2.rectangle(picture, (0, 0), (width - 1, low), (*BLACK, 255), -1)
    cv2.rectangle(picture, (5, 5), (width - 6, low - 8), (150, 118, 76, 255), -1)
    for _ in range(3):
        left, top = random.integers((12, 10), (width // 2, low // 2)).tolist()
        right, bottom = left + width // 3, top + low // 3
        cv2.rectangle(picture, (left, top), (right, bottom), (236, 236, 234, 255), -1)
        for row in range(top + 8, bottom - 3, 6):
            end = left + 6 + int(random.integers(8, max(9, right - left - 14)))
            cv2.line(picture, (left + 6, row), (end, row), (130, 128, 124, 255), 2)
    return picture


def books(random: np.random.Generator, px_per_m: float) -> Image:
    """A stack of books that lie."""
    picture = _empty(px_per_m, 0.30, 0.16)
    height, width = picture.shape[:2]
    bottom = height
    while bottom > 12:
        thick, inset = int(random.integers(7, 14)), int(random.integers(0, 14))
        _spine(random, picture, (inset, bottom - thick, width - 1 - int(random.integers(0, 14)), bottom - 1))
        bottom -= thick
    return picture


def plant(random: np.random.Generator, px_per_m: float) -> Image:
    """Leaves in a pot."""
    picture = _empty(px_per_m, 0.34, 0.48)
    height, width = picture.shape[:2]
    foot = width // 2, round(0.72 * height)
    for _ in range(26):
        angle, length = random.uniform(-170.0, -10.0), random.uniform(0.25, 0.62) * height
        end = np.array(foot) + length * np.array([0.7 * np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        middle = np.rint((np.array(foot) + 2.0 * end) / 3.0).astype(int).tolist()
        green = (int(random.integers(30, 60)), int(random.integers(80, 140)), int(random.integers(40, 80)), 255)
        cv2.ellipse(picture, middle, (round(0.3 * length), 7), angle, 0, 360, green, -1, cv2.LINE_AA)
    pot = [[foot[0] - 32, foot[1]], [foot[0] + 32, foot[1]], [foot[0] + 24, height - 1], [foot[0] - 24, height - 1]]
    cv2.fillConvexPoly(picture, np.array(pot), (206, 208, 210, 255), cv2.LINE_AA)
    return picture


def mug(random: np.random.Generator, px_per_m: float) -> Image:
    """A mug with its handle."""
    picture = _empty(px_per_m, 0.13, 0.10)
    height, width = picture.shape[:2]
    colour = (*INKS[random.integers(len(INKS))], 255)
    cv2.ellipse(picture, (round(0.68 * width), height // 2), (9, 8), 0, 0, 360, colour, 3, cv2.LINE_AA)
    cv2.rectangle(picture, (4, 1), (round(0.66 * width), height - 1), colour, -1)
    return picture


def _spine(random: np.random.Generator, picture: Image, box: tuple[int, int, int, int]) -> None:
    left, top, right, bottom = box
    shade = random.uniform(0.6, 1.3) * np.array(INKS[random.integers(len(INKS))])
    colour = tuple(int(c) for c in np.clip(shade, 20, 235))
    cv2.rectangle(picture, (left, top), (right, bottom), (*colour, 255), -1)
    if right - left > 12 and bottom - top > 30:
        cv2.rectangle(picture, (left + 3, top + 8), (right - 3, top + 24), (222, 226, 226, 255), -1)


def _empty(px_per_m: float, width_m: float, height_m: float) -> Image:
    return np.zeros((round(height_m * px_per_m), round(width_m * px_per_m), 4), np.uint8)
