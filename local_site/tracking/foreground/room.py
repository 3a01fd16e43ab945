"""What one camera sees behind the arm: a mean picture, learned while the arm is elsewhere."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.undistortion import TakenPicture
from local_site.kernels.compiled import compiled

Levels = NDArray[np.float32]
Planes = NDArray[np.float32]
ColourPlanes = NDArray[np.uint8]
Mask = NDArray[np.uint8]
Place = tuple[int, int, int]

STRIPS = 16  # a picture's rows are learned in turn, so that each pair costs little
LEAST_SHARE = 0.03  # of a new picture in the mean: half a second is remembered at 30 pairs/s and 16 strips
GAIN_STRIDE, GAIN_KEPT = 16, 0.8
MOST_GAIN = 1.5
AROUND = 25  # squares over which shadows are alike: a tenth of a metre
LARGEST_SHADOW = 3.0
FEW = 0.02  # of the squares around are enough to know the light


@dataclass(frozen=True, slots=True)
class Behind:
    """Behind squares: the colours (3, h, w) as lit today, whether they are known (h, w), and the gain (h, w) of the
    light there over the room's mean."""

    colours: Planes
    known: Mask
    gain: Levels


class RoomModel:
    """The mean colours (H, W, 3) of the room, how often each pixel was seen (H, W), and today's gain over the mean."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.mean: Levels = np.zeros((*shape, 3), np.float32)
        self.seen: Mask = np.zeros(shape, np.uint8)
        self.gain = 1.0
        self._strip = 0
        spots = np.indices(shape)[:, GAIN_STRIDE // 2 :: GAIN_STRIDE, GAIN_STRIDE // 2 :: GAIN_STRIDE]
        self._spots = np.ascontiguousarray(spots[::-1].reshape(2, -1).T, np.int32)
        self._squares: Planes = np.empty((3, 0, 0), np.float32)
        self._stride = 0

    def learn(self, picture: TakenPicture) -> None:
        """Learn from a picture without the arm."""
        nothing = np.zeros(self.seen.shape, np.uint8)
        self._learn(picture, nothing, (0, len(self.seen)), 1.0)

    def behind(self, colours: ColourPlanes, arm: Mask, place: Place) -> Behind:
        """What is behind squares of today's mean colours (3, h, w), if the light is there as it is around them.

        `arm` (h, w) is not 0 where the arm may be; `place` is left and top of the first square in px and their side,
        of which left and top are multiples.
        """
        left, top, stride = place
        rows, columns = arm.shape
        known = self.seen[top : top + rows * stride : stride, left : left + columns * stride : stride]
        known = np.ascontiguousarray(known)
        if not known.any():
            return Behind(np.zeros((3, rows, columns), np.float32), known, np.ones((rows, columns), np.float32))
        x, y = left // stride, top // stride
        mean = np.ascontiguousarray(self._by_squares(stride)[:, y : y + rows, x : x + columns])
        lit, gain = _lit(colours, mean, np.asarray((arm == 0) & (known > 0), np.float32), self.gain)
        return Behind(lit, known, gain)

    def follow(self, picture: TakenPicture, arm: Mask) -> None:
        """Learn a strip of a picture where `arm` (H, W) is 0, and follow the gain of the whole."""
        found = _gain(self.mean, self.seen, np.ascontiguousarray(picture.at(self._spots)), self._spots, arm)
        if 1.0 / MOST_GAIN < found < MOST_GAIN:
            self.gain = GAIN_KEPT * self.gain + (1.0 - GAIN_KEPT) * found
        rows = len(self.seen)
        bounds = self._strip * rows // STRIPS, (self._strip + 1) * rows // STRIPS
        self._strip = (self._strip + 1) % STRIPS
        self._learn(picture, arm, bounds, self.gain)

    def _learn(self, picture: TakenPicture, arm: Mask, rows: tuple[int, int], gain: float) -> None:
        strip = np.ascontiguousarray(picture.part(slice(*rows)))
        _learn(self.mean, self.seen, strip, arm, rows, gain)
        if self._stride:
            self._renew(rows[0] // self._stride, -(-rows[1] // self._stride))

    def _by_squares(self, stride: int) -> Planes:
        """The mean colours (3, h, w) of the whole picture's squares; only what is learned later is renewed."""
        if stride != self._stride:
            rows, columns = self.seen.shape[0] // stride, self.seen.shape[1] // stride
            self._stride, self._squares = stride, np.empty((3, rows, columns), np.float32)
            self._renew(0, rows)
        return self._squares

    def _renew(self, first: int, end: int) -> None:
        rows, columns = self._squares.shape[1:]
        end = min(end, rows)
        part = self.mean[first * self._stride : end * self._stride, : columns * self._stride]
        squares = cv2.resize(part, (columns, end - first), interpolation=cv2.INTER_AREA)
        self._squares[:, first:end] = squares.transpose(2, 0, 1)


@compiled
def _learn(mean: Levels, seen: Mask, strip: Image, arm: Mask, rows: tuple[int, int], gain: float) -> None:
    for y in range(rows[0], rows[1]):
        for x in range(seen.shape[1]):
            if arm[y, x]:
                continue
            if seen[y, x] < 255:
                seen[y, x] += 1
            share = max(1.0 / seen[y, x], LEAST_SHARE)
            for c in range(3):
                mean[y, x, c] += share * (strip[y - rows[0], x, c] / gain - mean[y, x, c])


@compiled
def _gain(mean: Levels, seen: Mask, colours: ColourPlanes, spots: NDArray[np.int32], arm: Mask) -> float:
    """The median of today's brightness over the mean's at spots (N, 2) with colours (N, 3) where the arm is not; 1
    without any."""
    ratios = np.empty(len(spots))
    count = 0
    for n in range(len(spots)):
        x, y = spots[n]
        before = mean[y, x, 0] + mean[y, x, 1] + mean[y, x, 2]
        if seen[y, x] and not arm[y, x] and before > GAIN_STRIDE:
            now = float(colours[n, 0]) + float(colours[n, 1]) + float(colours[n, 2])
            ratios[count] = now / before
            count += 1
    if count == 0:
        return 1.0
    found: Array = np.sort(ratios[:count])
    return float(found[count // 2])


def _lit(colours: ColourPlanes, mean: Planes, weights: Levels, overall: float) -> tuple[Planes, Levels]:
    """The mean colours (3, h, w) in today's light, and its gain (h, w) over the mean.

    The gain is found from the squares around that surely show the room; without any it is `overall`.
    """
    window = (AROUND, AROUND)
    brightness = _brightness(colours, mean, weights)
    now, before, share = (cv2.boxFilter(plane, cv2.CV_32F, window) for plane in (*brightness, weights))
    return _gained(mean, np.asarray(now), np.asarray(before), np.asarray(share), overall)


@compiled
def _brightness(colours: ColourPlanes, mean: Planes, weights: Levels) -> Planes:
    """The sums of the three planes of today's and of the mean colours, weighted (2, h, w)."""
    sums = np.empty((2, *weights.shape), np.float32)
    for j in range(weights.shape[0]):
        for i in range(weights.shape[1]):
            now = float(colours[0, j, i]) + float(colours[1, j, i]) + float(colours[2, j, i])
            sums[0, j, i] = weights[j, i] * now
            sums[1, j, i] = weights[j, i] * (mean[0, j, i] + mean[1, j, i] + mean[2, j, i])
    return sums


@compiled
def _gained(mean: Planes, now: Levels, before: Levels, share: Levels, overall: float) -> tuple[Planes, Levels]:
    lit, gains = np.empty_like(mean), np.empty_like(now)
    for j in range(now.shape[0]):
        for i in range(now.shape[1]):
            is_known = (share[j, i] > FEW) & (before[j, i] > 0.0)
            gain = now[j, i] / before[j, i] if is_known else overall
            gains[j, i] = min(max(gain, 1.0 / LARGEST_SHADOW), LARGEST_SHADOW)
            for c in range(3):
                lit[c, j, i] = gains[j, i] * mean[c, j, i]
    return lit, gains
