"""The bright spots of one picture, each with its intensity-weighted centroid to a fraction of a pixel."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np
from scipy.optimize import linear_sum_assignment

from common.cameras.camera import Frame, Image
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration
from local_site.kernels.pictures import as_grey
from local_site.tracking.tracker import FrameCache, View

Outline = cv2.typing.MatLike

MAX_SPOTS = 8
MAX_OUTLINES = 300
PEAK_PIXELS = 5
SEED_LEVEL = 0.3
MIN_PIXELS = 6
MAX_PICTURE_FRACTION = 0.01
MAX_ELONGATION = 4.0
MIN_FILLING = 0.45
SPREAD_PX = 3
RING_PX = 5
LEAST_NOISE = 0.5
BRIGHT_QUANTILE = 0.8
# Weights count from here up, so that a glove on one side and a black background on the other do not draw the centroid.
FOOT_LEVEL = 0.4

_DISC = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * SPREAD_PX + 1, 2 * SPREAD_PX + 1))


@dataclass(frozen=True, slots=True)
class Spots:
    """N bright spots of one camera: where the picture shows them (N, 2) px, where a pinhole's would (N, 2) px, the
    standard deviation of either coordinate from sensor noise (N,) px, and their areas (N,) px²."""

    in_picture: Array
    pixels: Array
    sigmas: Array
    areas: Array

    def __len__(self) -> int:
        return len(self.areas)


NO_SPOTS = Spots(np.empty((0, 2)), np.empty((0, 2)), np.empty(0), np.empty(0))


def find_spots(image: Image, min_contrast: float) -> Spots | str:
    """The marker-like spots of a picture (H, W) or (H, W, 3), or a sentence with the reason why there are none."""
    if image.dtype != np.uint8 or image.ndim not in (2, 3) or 0 in image.shape or image.shape[2:] not in ((), (3,)):
        return "the picture is empty or of a wrong kind"
    grey = as_grey(image)
    background, peak = _levels(grey)
    if peak - background < min_contrast:
        return "nothing is bright enough: no marker in view, or too little light on them"
    level = background + max(SEED_LEVEL * (peak - background), 0.5 * min_contrast)
    mask = np.asarray(cv2.threshold(grey, level, 255, cv2.THRESH_BINARY)[1], dtype=np.uint8)
    outlines = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    if len(outlines) > MAX_OUTLINES:
        return "the picture is full of bright spots"
    spots = [_measure(grey, mask, outline) for outline in outlines if _is_marker_like(outline, grey.shape)]
    bright = [spot for spot in spots if spot is not None and spot.brightness >= min_contrast]
    if not bright:
        return "no bright spot looks like a marker: a dark glove and a dark background are needed"
    table = np.array(sorted(bright, key=lambda spot: -spot.area * spot.brightness)[:MAX_SPOTS])
    return Spots(table[:, :2], table[:, :2], table[:, 2], table[:, 3])


class _Spot(NamedTuple):
    """Centroid and its noise in px, area in px², and brightness above the surroundings."""

    u: float
    v: float
    sigma: float
    area: float
    brightness: float


def _levels(grey: Image) -> tuple[float, float]:
    """The median brightness, and the one that only the brightest few pixels exceed."""
    histogram = cv2.calcHist([grey], [0], None, [256], [0.0, 256.0]).ravel()
    below = np.cumsum(histogram)
    peak_rank = max(below[-1] - PEAK_PIXELS, 0.5 * below[-1])
    return float(np.searchsorted(below, 0.5 * below[-1])), float(np.searchsorted(below, peak_rank))


def _is_marker_like(outline: Outline, shape: tuple[int, ...]) -> bool:
    left, top, width, height = cv2.boundingRect(outline)
    # The outline runs through the centres of the outermost pixels.
    pixels = cv2.contourArea(outline) + 0.5 * len(outline) + 1.0
    inside = left > 0 and top > 0 and left + width < shape[1] and top + height < shape[0]
    size = MIN_PIXELS <= pixels <= max(MAX_PICTURE_FRACTION * shape[0] * shape[1], MIN_PIXELS)
    round_enough = max(width, height) <= MAX_ELONGATION * min(width, height)
    return inside and size and round_enough and pixels >= MIN_FILLING * width * height


def _measure(grey: Image, mask: Image, outline: Outline) -> _Spot | None:
    """One spot above its own surroundings."""
    left, top, width, height = cv2.boundingRect(outline)
    first = np.array([max(left - RING_PX, 0), max(top - RING_PX, 0)])
    window = np.s_[first[1] : top + height + RING_PX, first[0] : left + width + RING_PX]
    values = grey[window].astype(np.float64)
    own = np.zeros(values.shape, np.uint8)
    cv2.drawContours(own, [outline - first.astype(np.int32)], 0, 255, cv2.FILLED)
    others = cv2.dilate(cv2.subtract(mask[window], own), _DISC) > 0
    region = (cv2.dilate(own, _DISC) > 0) & (~others | (own > 0))
    around, noise = _surroundings(values[~region & ~others])
    bright = _quantile(values[own > 0], BRIGHT_QUANTILE) - around
    weights = np.where(region, values - around - FOOT_LEVEL * bright, 0.0)
    v, u = np.nonzero(weights > 0)
    weight = weights[v, u]
    total = float(weight.sum())
    if total <= 0 or bright <= 0:
        return None
    centre_u, centre_v = float(u @ weight) / total, float(v @ weight) / total
    spread = 0.5 * float(np.sum((u - centre_u) ** 2 + (v - centre_v) ** 2))
    # Stretched about its middle, so that blurred edges count by half and the surroundings not at all.
    area = float(np.clip(2.0 * (values[region] - around) / bright - 0.5, 0.0, 1.0).sum())
    return _Spot(first[0] + centre_u, first[1] + centre_v, noise * math.sqrt(spread) / total, area, bright)


def _surroundings(ring: Array) -> tuple[float, float]:
    """The median brightness about a spot, and the noise there as a standard deviation."""
    if not ring.size:
        return 0.0, LEAST_NOISE
    around = _quantile(ring, 0.5)
    return around, max(1.4826 * _quantile(np.abs(ring - around), 0.5), LEAST_NOISE)


def _quantile(values: Array, fraction: float) -> float:
    """The value among (N,) with this fraction of them below it."""
    rank = int(fraction * (len(values) - 1))
    return float(np.partition(values, rank)[rank])


MAX_STEP_PX = 80.0
# A spot that accelerates between two exposures leaves the straight line by at most this fraction of its step.
CURVATURE = 0.02


class SpotFinder:
    """Finds the spots of one camera, undistorts them, and interpolates them between two exposures."""

    def __init__(self, camera: CameraCalibration, min_contrast: float) -> None:
        self._camera = camera
        self._min_contrast = min_contrast
        self._frames = FrameCache(interpolated)

    def spots(self, view: View) -> Spots | str:
        """The spots at the view's instant, or a sentence with the camera's name and the reason why there are none."""
        return self._frames.at(view, self._search)

    def _search(self, frame: Frame) -> Spots | str:
        found = find_spots(frame.image, self._min_contrast)
        if isinstance(found, str):
            return f"{self._camera.name}: {found}"
        return replace(found, pixels=self._camera.undistort_pixels(found.in_picture))


def interpolated(before: Spots, now: Spots, weight: float) -> Spots:
    """The spots that both frames show, at (1 - weight) * before + weight * now.

    They are paired so that the sum of squared steps is least, which a step common to all of them does not change.
    """
    steps2 = np.sum((before.pixels[:, None] - now.pixels[None]) ** 2, axis=2)
    rows, columns = linear_sum_assignment(steps2)
    near = steps2[rows, columns] <= MAX_STEP_PX**2
    a, b = rows[near], columns[near]
    curved = 4.0 * weight * (1.0 - weight) * CURVATURE * np.sqrt(steps2[a, b])
    noise2 = ((1.0 - weight) * before.sigmas[a]) ** 2 + (weight * now.sigmas[b]) ** 2

    def between(start: Array, end: Array) -> Array:
        return (1.0 - weight) * start + weight * end

    return Spots(
        in_picture=between(before.in_picture[a], now.in_picture[b]),
        pixels=between(before.pixels[a], now.pixels[b]),
        sigmas=np.sqrt(noise2 + curved**2),
        areas=between(before.areas[a], now.areas[b]),
    )
