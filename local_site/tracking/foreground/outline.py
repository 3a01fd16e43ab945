"""The arm's outline with subpixel precision: how much of each pixel near it the arm covers."""

import math

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.foreground.likelihood import RoomPicture, Tables, log_ratio
from local_site.tracking.foreground.room import Levels, Mask

LEVEL = 127.5
BAND = 2  # squares on both sides of the region's border
NEARBY = 7  # squares over which the colours of arm and room are averaged
CLEAR = 24.0  # levels between the colours of arm and room from which on a pixel's mixture can be told

Place = tuple[int, int, int]


def find_outline(
    picture: Image, colours: Image, arm: Mask, place: Place, room: RoomPicture, tables: Tables, shape: tuple[int, int]
) -> Silhouette | None:
    """The silhouette in a picture (H, W, 3) of the arm's squares (h, w), whose mean colours are (h, w, 3)."""
    left, top, stride = place
    cover = _cover(picture, _nearby(colours, arm), arm, place, room, tables)
    cover = np.asarray(cv2.GaussianBlur(cover, (3, 3), 0), dtype=np.uint8)
    mask = cv2.threshold(cover, LEVEL, 255, cv2.THRESH_BINARY)[1]
    contours = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    if not contours:
        return None
    largest = max(contours, key=cv2.contourArea)
    solid = np.zeros_like(cover)
    cv2.drawContours(solid, [largest], -1, math.ceil(LEVEL) + 1, cv2.FILLED)
    grey = np.zeros(shape, np.uint8)
    rows, columns = cover.shape
    grey[top : top + rows, left : left + columns] = cv2.max(solid, cover)
    return Silhouette(grey, LEVEL, largest.reshape(-1, 2).astype(np.float64) + (left, top))


def _nearby(colours: Image, arm: Mask) -> tuple[Levels, Levels]:
    """The mean colours (h, w, 3) of the arm and of what is not the arm around each square, away from the border."""
    kernel = np.ones((3, 3), np.uint8)
    inside = cv2.erode(arm, kernel, borderType=cv2.BORDER_REPLICATE)
    outside = cv2.erode(1 - arm, kernel, iterations=BAND, borderType=cv2.BORDER_REPLICATE)
    return _mean_where(colours, inside), _mean_where(colours, outside)


def _mean_where(colours: Image, where: cv2.typing.MatLike) -> Levels:
    weights = cv2.boxFilter(where, cv2.CV_32F, (NEARBY, NEARBY), normalize=False)
    sums = cv2.boxFilter(colours * where[..., None], cv2.CV_32F, (NEARBY, NEARBY), normalize=False)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(sums / weights[..., None], dtype=np.float32)


@compiled
def _cover(
    picture: Image, nearby: tuple[Levels, Levels], arm: Mask, place: Place, room: RoomPicture, tables: Tables
) -> Image:
    """How much the arm covers each pixel of the squares, from 0 to 255."""
    left, top, stride = place
    rows, columns = arm.shape
    cover = np.zeros((rows * stride, columns * stride), np.uint8)
    for j in range(rows):
        for i in range(columns):
            kind = _kind(arm, i, j)
            if kind == 0:
                continue
            for y in range(j * stride, (j + 1) * stride):
                for x in range(i * stride, (i + 1) * stride):
                    cover[y, x] = 255
                    if kind == 2:
                        of_arm, of_rest = nearby[0][j, i], nearby[1][j, i]
                        cover[y, x] = _covered(picture, left + x, top + y, of_arm, of_rest, room, tables)
    return cover


@compiled
def _kind(arm: Mask, i: int, j: int) -> int:
    """0 for a square outside, 1 inside, 2 near the border."""
    rows, columns = arm.shape
    value = arm[j, i]
    for y in range(max(j - BAND, 0), min(j + BAND + 1, rows)):
        for x in range(max(i - BAND, 0), min(i + BAND + 1, columns)):
            if arm[y, x] != value:
                return 2
    return int(value)


@compiled
def _covered(picture: Image, x: int, y: int, of_arm: Array, of_rest: Array, room: RoomPicture, tables: Tables) -> int:
    """How much of a pixel the arm covers, from 0 to 255: the share of the arm's colour in its mixture with what is
    behind it where the two differ, else how likely it is the arm."""
    mean, seen, gain = room
    known = seen[y, x] > 0
    colour = (float(picture[y, x, 0]), float(picture[y, x, 1]), float(picture[y, x, 2]))
    behind = (gain * float(mean[y, x, 0]), gain * float(mean[y, x, 1]), gain * float(mean[y, x, 2]))
    likely = 1.0 / (1.0 + math.exp(-log_ratio(colour, behind, known, tables)))
    square, along = 0.0, 0.0
    for c in range(3):
        back = behind[c] if known else of_rest[c]
        way = of_arm[c] - back
        square += way * way
        along += way * (colour[c] - back)
    if math.isnan(square):
        return int(255.0 * likely)
    share = min(max(along / max(square, 1.0), 0.0), 1.0)
    clear = square / (square + CLEAR * CLEAR)
    return int(255.0 * (clear * share + (1.0 - clear) * likely))
