"""The arm's silhouette in one image: threshold from the histogram, outer contour (thesis 3.1.2, 3.1.3)."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array

MIN_AREA_FRACTION = 1e-3
MIN_CONTOUR_POINTS = 40

ROOM_CURE = 'in an ordinary room take tracking.method = "learned"'


@dataclass(frozen=True, slots=True)
class Silhouette:
    """The arm's blob: smoothed grey image (H, W), threshold level, ordered outer contour (N, 2) in px.

    Shadows within the contour are raised above the level, so that they do not look like the arm's edge. Where `grey` is
    no picture but how far the arm covers each pixel, `picture` (H, W) shows the edges within the arm.
    """

    grey: NDArray[np.uint8]
    level: float
    contour: Array
    picture: NDArray[np.uint8] | None = None

    def touches_border(self, points: Array) -> NDArray[np.bool_]:
        """Return which pixels (N, 2) lie on the image border, (N,)."""
        height, width = self.grey.shape
        touching: NDArray[np.bool_] = np.any((points <= 1) | (points >= (width - 2, height - 2)), axis=1)
        return touching

    @property
    def at_border(self) -> bool:
        """Return whether the image border cuts the arm."""
        return bool(self.touches_border(self.contour).any())


def to_grey(image: Image) -> NDArray[np.uint8]:
    """The image as smoothed grey (H, W); colours are weighted as usual, other channel counts use the first."""
    if image.ndim == 3:
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.shape[2] == 3 else image[..., 0]
    else:
        grey = image
    return np.asarray(cv2.GaussianBlur(np.ascontiguousarray(grey), (3, 3), 0), dtype=np.uint8)


def find_silhouette(grey: NDArray[np.uint8], level: float) -> Silhouette | None:
    """The largest bright blob of a smoothed grey image, or None when none is large enough to be an arm."""
    mask = cv2.threshold(grey, level, 255, cv2.THRESH_BINARY)[1]
    contours = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    if not contours:
        return None
    largest = max(contours, key=cv2.contourArea)
    if cv2.contourArea(largest) < MIN_AREA_FRACTION * grey.size or len(largest) < MIN_CONTOUR_POINTS:
        return None
    solid = np.zeros_like(grey)
    cv2.drawContours(solid, [largest], -1, math.ceil(level) + 1, cv2.FILLED)
    solid = np.asarray(cv2.max(solid, grey), dtype=np.uint8)
    return Silhouette(solid, level, largest.reshape(-1, 2).astype(np.float64))


STRIDE = 2
SMOOTHING_LEVELS = 4.0
RISE = 0.15
BACKGROUND_SIGMAS = 5.0
MIN_CONTRAST_SIGMAS = 10.0
MIN_CONTRAST_LEVELS = 12.0
MIN_ARM_FRACTION = 5e-4
MAX_ARM_FRACTION = 0.6
MAX_VALLEY = 0.6


def find_threshold(grey: NDArray[np.uint8]) -> float | str:
    """The grey level above which a pixel of an image (H, W) is arm; a sentence if the histogram has no two modes.

    It is the background's level plus the fraction RISE of the difference to the arm's: half would be the unbiased
    edge but loses skin in the shadow of the hand.
    """
    histogram = np.bincount(grey[::STRIDE, ::STRIDE].ravel(), minlength=256).astype(float)
    total = float(histogram.sum())
    if total == 0:
        return "the image is empty"
    split = _otsu(histogram)
    levels = np.arange(256.0)
    dark, bright = histogram[: split + 1], histogram[split + 1 :]
    if not MIN_ARM_FRACTION <= bright.sum() / total <= MAX_ARM_FRACTION:
        return f"no arm in the picture: nothing stands out bright from the background; {ROOM_CURE}"
    background, sigma = _robust(dark, levels[: split + 1])
    arm = float(bright @ levels[split + 1 :] / bright.sum())
    contrast = arm - background
    if contrast < max(MIN_CONTRAST_LEVELS, MIN_CONTRAST_SIGMAS * sigma) or _unimodal(histogram, background, arm):
        return "arm and background have no clear valley between them: darken the background"
    return max(background + RISE * contrast, background + BACKGROUND_SIGMAS * sigma)


def _otsu(histogram: Array) -> int:
    """The last level of the darker class."""
    levels = np.arange(256.0)
    weight = np.cumsum(histogram)
    first = np.cumsum(histogram * levels)
    rest = weight[-1] - weight
    with np.errstate(divide="ignore", invalid="ignore"):
        between = (first[-1] * weight - first * weight[-1]) ** 2 / (weight * rest)
    return int(np.argmax(np.nan_to_num(between, posinf=0.0)))


def _robust(histogram: Array, levels: Array) -> tuple[float, float]:
    """Median and spread (half the 16th to 84th percentile) of a class, which a few arm pixels hardly change."""
    cumulative = np.cumsum(histogram) / histogram.sum()
    low, middle, high = (float(levels[np.searchsorted(cumulative, q)]) for q in (0.16, 0.5, 0.84))
    return middle, max(0.5 * (high - low), 0.5)


def _unimodal(histogram: Array, background: float, arm: float) -> bool:
    """Return whether the smoothed histogram never rises again between the background's peak and the arm's mean."""
    smooth = cv2.GaussianBlur(histogram[None, :], (0, 0), SMOOTHING_LEVELS)[0]
    start = round(background)
    valley = start + int(np.argmin(smooth[start : max(round(arm), start + 1)]))
    return float(smooth[valley]) > MAX_VALLEY * float(smooth[valley:].max())
