"""The arm's outline with subpixel precision: how much of each pixel near it the arm covers."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from local_site.kernels.compiled import compiled
from local_site.kernels.pictures import grey_at
from local_site.tracking.features.silhouette import MIN_CONTOUR_POINTS, Silhouette
from local_site.tracking.foreground.likelihood import LogRatios, Tables, log_ratios
from local_site.tracking.foreground.room import Behind, ColourPlanes, Levels, Mask, Place, Planes, RoomModel

LEVEL = 127.5
KERNEL = np.ones((3, 3), np.uint8)
OUTSIDE, INSIDE = 1, 2
TRUST = 2.0  # the log ratio of the squares' own region
BESIDE = 20.0  # levels by which a mixture may differ from one of the two colours
NEARBY = 7  # squares over which the colours of arm and room are averaged
CLEAR = 24.0  # levels between the colours of arm and room from which on a pixel's mixture can be told
SURE = 0.95  # that it can be told: how likely the pixel is the arm does not count any more

Sums = NDArray[np.uint16]


class Rim(NamedTuple):
    """The pixels between inside and outside: positions (N, 2) in the part, colours (3, N), what is behind them (3, N)
    where it is known (N,), the mean colours of the arm and of the rest around (3, N), and what the squares' region says
    (N,), a log ratio."""

    pixels: NDArray[np.int32]
    colours: ColourPlanes
    behind: Planes
    known: Mask
    arm: Planes
    rest: Planes
    prior: LogRatios


def find_outline(
    picture: Image, colours: ColourPlanes, arm: Mask, place: Place, room: RoomModel, behind: Behind, tables: Tables
) -> Silhouette | None:
    """The silhouette of the arm's squares (h, w), whose mean colours are (3, h, w) and whose pixels are `picture`."""
    x, y, w, h = cv2.boundingRect(cv2.dilate(arm, KERNEL, iterations=2))
    part = np.s_[y : y + h, x : x + w]
    left, top, stride = place[0] + x * place[2], place[1] + y * place[2], place[2]
    arm, gain = np.ascontiguousarray(arm[part]), np.ascontiguousarray(behind.gain[part])
    inside = np.asarray(cv2.erode(arm, KERNEL, borderType=cv2.BORDER_REPLICATE), np.uint8)
    outside = np.asarray(1 - cv2.dilate(arm, KERNEL, borderType=cv2.BORDER_REPLICATE), np.uint8)
    trust = cv2.blur(arm * np.float32(2.0 * TRUST) - np.float32(TRUST), (3, 3))
    squares = np.asarray(cv2.merge([*(plane[part] for plane in colours), np.ones_like(arm)]), np.uint8)
    nearby = _sums_where(squares, inside), _sums_where(squares, outside)
    kinds = np.asarray(2 * inside + outside, np.uint8)
    pixels = np.ascontiguousarray(picture[y * stride : (y + h) * stride, x * stride : (x + w) * stride])
    rim = _rim(pixels, (room.mean, room.seen, gain), nearby, kinds, np.asarray(trust), (left, top, stride))
    covered = _covered(rim, log_ratios(rim.colours, rim.behind, rim.known, tables))
    cover = _cover(kinds, stride, rim.pixels, covered)
    return _silhouette(np.asarray(cv2.GaussianBlur(cover, (3, 3), 0), np.uint8), (left, top), room.seen.shape)


def _silhouette(cover: Mask, corner: tuple[int, int], shape: tuple[int, ...]) -> Silhouette | None:
    """The silhouette in a picture of a shape of the largest part that is covered, whose corner is at (x, y) in px."""
    left, top = corner
    mask = cv2.threshold(cover, LEVEL, 255, cv2.THRESH_BINARY)[1]
    contours = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    largest = max(contours, key=cv2.contourArea, default=np.empty((0, 1, 2), np.int32))
    if len(largest) < MIN_CONTOUR_POINTS:
        return None
    solid = np.zeros_like(cover)
    cv2.drawContours(solid, [largest], -1, math.ceil(LEVEL) + 1, cv2.FILLED)
    grey = np.zeros(shape, np.uint8)
    rows, columns = cover.shape
    grey[top : top + rows, left : left + columns] = cv2.max(solid, cover)
    contour = np.asarray(largest.reshape(-1, 2) + np.array([left, top]), dtype=np.float64)
    return Silhouette(grey, LEVEL, contour)


def _sums_where(squares: Mask, where: Mask) -> Sums:
    """The sums (h, w, 4) over the squares around each where `where` (h, w) is 1: of the colours, and their number."""
    masked = cv2.bitwise_and(squares, squares, mask=where)
    return np.asarray(cv2.boxFilter(masked, cv2.CV_16U, (NEARBY, NEARBY), normalize=False), np.uint16)


@compiled
def _rim(
    picture: Image,
    room: tuple[Levels, Mask, Levels],
    nearby: tuple[Sums, Sums],
    kinds: Mask,
    trust: Levels,
    place: Place,
) -> Rim:
    """What is needed of the pixels of squares that are neither inside nor outside."""
    left, top, stride = place
    mean, seen, gain = room
    count = int(np.sum(kinds == 0)) * stride * stride
    rim = Rim(
        np.empty((count, 2), np.int32),
        np.empty((3, count), np.uint8),
        np.empty((3, count), np.float32),
        np.empty(count, np.uint8),
        np.empty((3, count), np.float32),
        np.empty((3, count), np.float32),
        np.empty(count, np.float32),
    )
    n = 0
    for j in range(kinds.shape[0]):
        for i in range(kinds.shape[1]):
            if kinds[j, i] != 0:
                continue
            for y in range(j * stride, (j + 1) * stride):
                for x in range(i * stride, (i + 1) * stride):
                    rim.pixels[n] = x, y
                    rim.known[n] = seen[top + y, left + x]
                    rim.prior[n] = grey_at(trust, (x + 0.5) / stride - 0.5, (y + 0.5) / stride - 0.5)
                    for c in range(3):
                        rim.colours[c, n] = picture[y, x, c]
                        rim.behind[c, n] = gain[j, i] * mean[top + y, left + x, c]
                        rim.arm[c, n] = nearby[0][j, i, c] / nearby[0][j, i, 3]
                        rim.rest[c, n] = nearby[1][j, i, c] / nearby[1][j, i, 3]
                    n += 1
    return rim


def _covered(rim: Rim, ratios: LogRatios) -> LogRatios:
    """How much of each pixel (N,) the arm covers, from 0 to 255.

    It is the share of the arm's colour in the pixel's, where this is a mixture of the arm's colour and what is behind
    it and the two differ; else how likely it is the arm.
    """
    shares, clear, beside = _mixed(rim)
    clear *= np.exp(beside)
    clear[clear > SURE] = 1.0
    likely = 1.0 / (1.0 + np.exp(-ratios - rim.prior))
    covered: LogRatios = np.float32(255.0) * (clear * shares + (1.0 - clear) * likely)
    return covered


@compiled
def _mixed(rim: Rim) -> tuple[LogRatios, LogRatios, LogRatios]:
    """The arm's share in the colour of each pixel (N,), how well arm and rest can be told apart there, and the exponent
    of how near the colour is to a mixture of the two."""
    count = len(rim.prior)
    shares, clear, beside = np.zeros(count, np.float32), np.zeros(count, np.float32), np.zeros(count, np.float32)
    for n in range(count):
        square, along, total = 0.0, 0.0, 0.0
        for c in range(3):
            back = rim.behind[c, n] if rim.known[n] > 0 else rim.rest[c, n]
            way, off = rim.arm[c, n] - back, rim.colours[c, n] - back
            square, along, total = square + way * way, along + way * off, total + off * off
        if not math.isnan(square) and square > 1.0:
            share = min(max(along / square, 0.0), 1.0)
            shares[n], clear[n] = share, square / (square + CLEAR * CLEAR)
            beside[n] = -0.5 * (total - 2.0 * share * along + share * share * square) / (BESIDE * BESIDE)
    return shares, clear, beside


@compiled
def _cover(kinds: Mask, stride: int, pixels: NDArray[np.int32], covered: LogRatios) -> Mask:
    """How much the arm covers each pixel of the squares, from 0 to 255, with what was found for those of the rim."""
    rows, columns = kinds.shape
    cover = np.zeros((rows * stride, columns * stride), np.uint8)
    for y in range(rows * stride):
        for i in range(columns):
            if kinds[y // stride, i] == INSIDE:
                cover[y, i * stride : (i + 1) * stride] = 255
    for n in range(len(covered)):
        cover[pixels[n, 1], pixels[n, 0]] = int(covered[n])
    return cover
