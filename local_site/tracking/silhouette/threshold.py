"""The threshold between a dark background and the arm, from the image's own histogram (thesis 3.1.2)."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array

STRIDE = 2
SMOOTHING_LEVELS = 4.0
RISE = 0.15
BACKGROUND_SIGMAS = 5.0
MIN_CONTRAST_SIGMAS = 10.0
MIN_CONTRAST_LEVELS = 12.0
MIN_ARM_FRACTION = 5e-4
MAX_ARM_FRACTION = 0.6
MAX_VALLEY = 0.6


@dataclass(frozen=True, slots=True)
class Threshold:
    """Grey level above which a pixel is arm; None with the reason where the histogram does not show two modes."""

    level: float | None
    reason: str = ""


def find_threshold(grey: NDArray[np.uint8]) -> Threshold:
    """The threshold of an image (H, W), a part of the way from the background's level to the arm's.

    A small part keeps skin in the shadow of the hand; half would be the unbiased edge but loses it.
    """
    histogram = np.bincount(grey[::STRIDE, ::STRIDE].ravel(), minlength=256).astype(float)
    total = float(histogram.sum())
    if total == 0:
        return Threshold(None, "the image is empty")
    split = _otsu(histogram)
    levels = np.arange(256.0)
    dark, bright = histogram[: split + 1], histogram[split + 1 :]
    if not MIN_ARM_FRACTION <= bright.sum() / total <= MAX_ARM_FRACTION:
        return Threshold(None, "no arm in the picture: nothing stands out bright from the background")
    background, sigma = _robust(dark, levels[: split + 1])
    arm = float(bright @ levels[split + 1 :] / bright.sum())
    contrast = arm - background
    if contrast < max(MIN_CONTRAST_LEVELS, MIN_CONTRAST_SIGMAS * sigma) or _unimodal(histogram, background, arm):
        return Threshold(None, "arm and background have no clear valley between them: darken the background")
    return Threshold(max(background + RISE * contrast, background + BACKGROUND_SIGMAS * sigma))


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
    """Median and spread of a class: folds and a gradient of the cloth widen the spread, a few arm pixels do not."""
    cumulative = np.cumsum(histogram) / histogram.sum()
    low, middle, high = (float(levels[np.searchsorted(cumulative, q)]) for q in (0.16, 0.5, 0.84))
    return middle, max(0.5 * (high - low), 0.5)


def _unimodal(histogram: Array, background: float, arm: float) -> bool:
    """Whether the smoothed histogram never rises again between the background's peak and the arm's mean."""
    smooth = cv2.GaussianBlur(histogram[None, :], (0, 0), SMOOTHING_LEVELS)[0]
    start = round(background)
    valley = start + int(np.argmin(smooth[start : max(round(arm), start + 1)]))
    return float(smooth[valley]) > MAX_VALLEY * float(smooth[valley:].max())
