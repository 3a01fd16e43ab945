"""The bright spots of one picture, each with its intensity-weighted centroid to a fraction of a pixel."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array

Labels = NDArray[np.int32]

MAX_SPOTS = 8
MAX_COMPONENTS = 300
PEAK_PIXELS = 20
SEED_SHARE = 0.3
MIN_PIXELS = 6
MAX_PICTURE_SHARE = 0.01
MAX_ELONGATION = 4.0
MIN_FILLING = 0.45
SPREAD_PX = 3
RING_PX = 5
LEAST_NOISE = 0.5

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
    """The marker-like spots of a picture (H, W) or (H, W, 3), or a sentence that says why there are none."""
    if image.dtype != np.uint8 or image.ndim not in (2, 3) or 0 in image.shape or image.shape[2:] not in ((), (3,)):
        return "the picture is empty or of a wrong kind"
    grey = image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
    background, peak = _levels(grey)
    if peak - background < min_contrast:
        return "nothing stands out brightly: no marker in view, or too little light on them"
    level = background + max(SEED_SHARE * (peak - background), 0.5 * min_contrast)
    mask = cv2.threshold(grey, level, 255, cv2.THRESH_BINARY)[1]
    found = cv2.connectedComponentsWithStats(mask, connectivity=8)
    count, labels, stats = found[0], np.asarray(found[1], dtype=np.int32), np.asarray(found[2], dtype=np.int32)
    if count > MAX_COMPONENTS:
        return "the picture is full of bright places"
    chosen = [k for k in range(1, count) if _is_marker_like(stats[k], grey.shape)]
    measured = [_measure(grey, labels, k, stats[k]) for k in chosen]
    kept = sorted((m for m in measured if m[4] >= min_contrast), key=lambda m: -m[3] * m[4])[:MAX_SPOTS]
    if not kept:
        return "no bright place looks like a marker: a dark glove and a dark background are needed"
    table = np.array(kept)
    return Spots(table[:, :2], table[:, :2], table[:, 2], table[:, 3])


def _levels(grey: Image) -> tuple[float, float]:
    """The median brightness, and the one that only the brightest few pixels exceed."""
    histogram = cv2.calcHist([grey], [0], None, [256], [0.0, 256.0]).ravel()
    below = np.cumsum(histogram)
    peak_rank = max(below[-1] - PEAK_PIXELS, 0.5 * below[-1])
    return float(np.searchsorted(below, 0.5 * below[-1])), float(np.searchsorted(below, peak_rank))


def _is_marker_like(stats: Labels, shape: tuple[int, ...]) -> bool:
    left, top, width, height, pixels = (int(value) for value in stats[:5])
    inside = left > 0 and top > 0 and left + width < shape[1] and top + height < shape[0]
    size = MIN_PIXELS <= pixels <= max(MAX_PICTURE_SHARE * shape[0] * shape[1], MIN_PIXELS)
    round_enough = max(width, height) <= MAX_ELONGATION * min(width, height)
    return inside and size and round_enough and pixels >= MIN_FILLING * width * height


def _measure(grey: Image, labels: Labels, label: int, stats: Labels) -> tuple[float, float, float, float, float]:
    """Centroid u and v, its noise (px), area (px²) and brightness of one spot above its own surroundings."""
    left, top, width, height = (int(value) for value in stats[:4])
    rows = slice(max(top - RING_PX, 0), top + height + RING_PX)
    columns = slice(max(left - RING_PX, 0), left + width + RING_PX)
    near = labels[rows, columns]
    own = cv2.dilate((near == label).astype(np.uint8), _DISC) > 0
    others = cv2.dilate(((near > 0) & (near != label)).astype(np.uint8), _DISC) > 0
    values = grey[rows, columns].astype(np.float64)
    ring = values[~own & ~others]
    around = float(np.median(ring)) if ring.size else 0.0
    noise = max(1.4826 * float(np.median(np.abs(ring - around))), LEAST_NOISE) if ring.size else LEAST_NOISE
    v, u = np.nonzero(own & (~others | (near == label)))
    weight = values[v, u] - around
    total = float(weight.sum())
    bright = float(np.percentile(values[near == label], 80)) - around
    if total <= 0 or bright <= 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    centre = np.array([u @ weight, v @ weight]) / total
    spread = float(np.sum((u - centre[0]) ** 2 + (v - centre[1]) ** 2)) / 2.0
    sigma = noise * np.sqrt(spread) / total
    return float(centre[0]) + columns.start, float(centre[1]) + rows.start, float(sigma), total / bright, bright
