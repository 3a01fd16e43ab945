"""What one camera sees behind the arm: a mean picture, learned while the arm is elsewhere."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled

Levels = NDArray[np.float32]
Mask = NDArray[np.uint8]
Place = tuple[int, int, int]

STRIPS = 16  # a picture's rows are learned in turn, so that each pair costs little
LEAST_SHARE = 0.03  # of a new picture in the mean: half a second is remembered at 30 pairs/s and 16 strips
GAIN_STRIDE, GAIN_KEPT = 16, 0.8
MOST_GAIN = 1.5
SUM = np.ones((1, 3), np.float32)
AROUND = 25  # squares over which shadows are alike: a tenth of a metre
LARGEST_SHADOW = 3.0
FEW = 0.02  # of the squares around are enough to know the light


@dataclass(frozen=True, slots=True)
class Behind:
    """Behind squares: the colours (h, w, 3) as lit today, whether they are known (h, w), and the gain (h, w) of the
    light there over the room's mean."""

    colours: Levels
    known: Mask
    gain: Levels


class RoomModel:
    """The mean colours (H, W, 3) of the room, how often each pixel was seen (H, W), and today's gain over the mean."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.mean: Levels = np.zeros((*shape, 3), np.float32)
        self.seen: Mask = np.zeros(shape, np.uint8)
        self.gain = 1.0
        self._strip = 0

    def learn(self, picture: Image) -> None:
        """Learn from a picture (H, W, 3) without the arm."""
        nothing = np.zeros(self.seen.shape, np.uint8)
        _learn(self.mean, self.seen, picture, nothing, (0, len(self.seen)), 1.0)

    def behind(self, colours: Image, arm: Mask, place: Place) -> Behind:
        """What is behind squares of today's mean colours (h, w, 3), if the light is there as it is around them.

        `arm` (h, w) is not 0 where the arm may be; `place` is left and top of the first square in px and their side.
        """
        left, top, stride = place
        rows, columns = arm.shape
        part = np.s_[top : top + rows * stride, left : left + columns * stride]
        known = np.asarray(cv2.resize(self.seen[part], (columns, rows), interpolation=cv2.INTER_NEAREST), np.uint8)
        if not known.any():
            return Behind(np.zeros((rows, columns, 3), np.float32), known, np.ones((rows, columns), np.float32))
        mean = np.asarray(cv2.resize(self.mean[part], (columns, rows), interpolation=cv2.INTER_AREA), np.float32)
        gain = _local_gain(colours, mean, np.asarray((arm == 0) & (known > 0), np.float32), self.gain)
        return Behind(mean * gain[..., None], known, gain)

    def follow(self, picture: Image, arm: Mask) -> None:
        """Learn a strip of a picture (H, W, 3) where `arm` (H, W) is 0, and follow the gain of the whole."""
        found = _gain(self.mean, self.seen, picture, arm)
        if 1.0 / MOST_GAIN < found < MOST_GAIN:
            self.gain = GAIN_KEPT * self.gain + (1.0 - GAIN_KEPT) * found
        rows = len(self.seen)
        bounds = self._strip * rows // STRIPS, (self._strip + 1) * rows // STRIPS
        self._strip = (self._strip + 1) % STRIPS
        _learn(self.mean, self.seen, picture, arm, bounds, self.gain)


@compiled
def _learn(mean: Levels, seen: Mask, picture: Image, arm: Mask, rows: tuple[int, int], gain: float) -> None:
    for y in range(rows[0], rows[1]):
        for x in range(seen.shape[1]):
            if arm[y, x]:
                continue
            if seen[y, x] < 255:
                seen[y, x] += 1
            share = max(1.0 / seen[y, x], LEAST_SHARE)
            for c in range(3):
                mean[y, x, c] += share * (picture[y, x, c] / gain - mean[y, x, c])


@compiled
def _gain(mean: Levels, seen: Mask, picture: Image, arm: Mask) -> float:
    """The median of the picture's brightness over the mean's, at some pixels where the arm is not; 1 without any."""
    ratios = np.empty((seen.shape[0] // GAIN_STRIDE + 1) * (seen.shape[1] // GAIN_STRIDE + 1))
    count = 0
    for y in range(GAIN_STRIDE // 2, seen.shape[0], GAIN_STRIDE):
        for x in range(GAIN_STRIDE // 2, seen.shape[1], GAIN_STRIDE):
            before = mean[y, x, 0] + mean[y, x, 1] + mean[y, x, 2]
            if seen[y, x] and not arm[y, x] and before > GAIN_STRIDE:
                now = float(picture[y, x, 0]) + float(picture[y, x, 1]) + float(picture[y, x, 2])
                ratios[count] = now / before
                count += 1
    if count == 0:
        return 1.0
    found: Array = np.sort(ratios[:count])
    return float(found[count // 2])


def _local_gain(colours: Image, mean: Levels, weights: Levels, overall: float) -> Levels:
    """The gain (h, w) of the light over the mean, from the squares around that surely show the room; else `overall`."""
    window = (AROUND, AROUND)
    now, before = (
        cv2.boxFilter(weights * cv2.transform(picture, SUM), cv2.CV_32F, window)
        for picture in (np.asarray(colours, np.float32), mean)
    )
    share = cv2.boxFilter(weights, cv2.CV_32F, window)
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where((share > FEW) & (before > 0), now / before, overall)
    return np.asarray(np.clip(gain, 1.0 / LARGEST_SHADOW, LARGEST_SHADOW), np.float32)
