"""The arm's outline with subpixel precision: how much of each pixel near it the arm covers."""

import math

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.features.silhouette import MIN_CONTOUR_POINTS, Silhouette
from local_site.tracking.foreground.likelihood import Tables, log_ratio
from local_site.tracking.foreground.room import Behind, Levels, Mask, Place, RoomModel

LEVEL = 127.5
KERNEL = np.ones((3, 3), np.uint8)
OUTSIDE, INSIDE = 1, 2
TRUST = 2.0  # the log ratio of the squares' own region
BESIDE = 20.0  # levels by which a mixture may differ from one of the two colours
NEARBY = 7  # squares over which the colours of arm and room are averaged
CLEAR = 24.0  # levels between the colours of arm and room from which on a pixel's mixture can be told


def find_outline(
    picture: Image, colours: Image, arm: Mask, place: Place, room: RoomModel, behind: Behind, tables: Tables
) -> Silhouette | None:
    """The silhouette in a picture (H, W, 3) of the arm's squares (h, w), whose mean colours are (h, w, 3)."""
    x, y, w, h = cv2.boundingRect(cv2.dilate(arm, KERNEL, iterations=2))
    part = np.s_[y : y + h, x : x + w]
    left, top, stride = place[0] + x * place[2], place[1] + y * place[2], place[2]
    arm, colours, gain = np.ascontiguousarray(arm[part]), colours[part], np.ascontiguousarray(behind.gain[part])
    inside = np.asarray(cv2.erode(arm, KERNEL, borderType=cv2.BORDER_REPLICATE), np.uint8)
    outside = np.asarray(1 - cv2.dilate(arm, KERNEL, borderType=cv2.BORDER_REPLICATE), np.uint8)
    size = (arm.shape[1] * stride, arm.shape[0] * stride)
    prior = cv2.resize(cv2.blur(arm * np.float32(2.0 * TRUST) - np.float32(TRUST), (3, 3)), size)
    nearby = _mean_where(colours, inside), _mean_where(colours, outside)
    kinds = np.asarray(2 * inside + outside, np.uint8)
    cover = _cover(
        picture, (room.mean, room.seen, gain), nearby, kinds, np.asarray(prior, np.float32), (left, top, stride), tables
    )
    cover = np.asarray(cv2.GaussianBlur(cover, (3, 3), 0), dtype=np.uint8)
    mask = cv2.threshold(cover, LEVEL, 255, cv2.THRESH_BINARY)[1]
    contours = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    largest = max(contours, key=cv2.contourArea, default=np.empty((0, 1, 2), np.int32))
    if len(largest) < MIN_CONTOUR_POINTS:
        return None
    solid = np.zeros_like(cover)
    cv2.drawContours(solid, [largest], -1, math.ceil(LEVEL) + 1, cv2.FILLED)
    grey = np.zeros(room.seen.shape, np.uint8)
    rows, columns = cover.shape
    grey[top : top + rows, left : left + columns] = cv2.max(solid, cover)
    contour = np.asarray(largest.reshape(-1, 2) + np.array([left, top]), dtype=np.float64)
    return Silhouette(grey, LEVEL, contour)


def _mean_where(colours: Image, where: Mask) -> Levels:
    """The mean colours (h, w, 3) of the squares around each where `where` (h, w) is 1; NaN without any."""
    weights = cv2.boxFilter(where, cv2.CV_32F, (NEARBY, NEARBY), normalize=False)
    sums = cv2.boxFilter(colours * where[..., None], cv2.CV_32F, (NEARBY, NEARBY), normalize=False)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(sums / weights[..., None], dtype=np.float32)


@compiled
def _cover(
    picture: Image,
    room: tuple[Levels, Mask, Levels],
    nearby: tuple[Levels, Levels],
    kinds: Mask,
    prior: Levels,
    place: Place,
    tables: Tables,
) -> Image:
    """How much the arm covers each pixel of the squares, from 0 to 255."""
    left, top, stride = place
    rows, columns = kinds.shape
    cover = np.zeros((rows * stride, columns * stride), np.uint8)
    for j in range(rows):
        for i in range(columns):
            if kinds[j, i] == OUTSIDE:
                continue
            for y in range(j * stride, (j + 1) * stride):
                for x in range(i * stride, (i + 1) * stride):
                    cover[y, x] = 255
                    if kinds[j, i] != INSIDE:
                        colours = (nearby[0][j, i], nearby[1][j, i])
                        pixel = (left + x, top + y)
                        cover[y, x] = _covered(picture, pixel, room, room[2][j, i], colours, prior[y, x], tables)
    return cover


@compiled
def _covered(
    picture: Image,
    pixel: tuple[int, int],
    room: tuple[Levels, Mask, Levels],
    gain: float,
    nearby: tuple[Array, Array],
    prior: float,
    tables: Tables,
) -> int:
    """How much of a pixel the arm covers, from 0 to 255.

    It is the share of the arm's colour in the pixel's, where this is a mixture of the arm's colour and what is behind
    it and the two differ; else how likely it is the arm.
    """
    x, y = pixel
    known = room[1][y, x] > 0
    colour = (float(picture[y, x, 0]), float(picture[y, x, 1]), float(picture[y, x, 2]))
    behind = (gain * room[0][y, x, 0], gain * room[0][y, x, 1], gain * room[0][y, x, 2])
    square, along, total = 0.0, 0.0, 0.0
    for c in range(3):
        back = behind[c] if known else float(nearby[1][c])
        way, off = nearby[0][c] - back, colour[c] - back
        square, along, total = square + way * way, along + way * off, total + off * off
    clear, share = 0.0, 0.0
    if not math.isnan(square) and square > 1.0:
        share = min(max(along / square, 0.0), 1.0)
        beside = total - 2.0 * share * along + share * share * square
        clear = square / (square + CLEAR * CLEAR) * math.exp(-0.5 * beside / (BESIDE * BESIDE))
    if clear > 0.95:
        return int(255.0 * share)
    likely = 1.0 / (1.0 + math.exp(-log_ratio(colour, behind, known, tables) - prior))
    return int(255.0 * (clear * share + (1.0 - clear) * likely))
