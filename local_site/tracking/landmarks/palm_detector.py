"""Finds palms in a picture, wherever they are and however turned."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.tracking.landmarks.crop import Crop, upright
from local_site.tracking.landmarks.network import LandmarkNetwork

GRIDS = ((24, 2), (12, 6))  # cells a side, and anchors in each cell
WRIST, MIDDLE_KNUCKLE = 0, 2  # of the detector's seven points
LEAST_SCORE = 0.5
OVERLAP = 0.3
HAND_SCALE, HAND_SHIFT = 2.6, 0.5  # of the palm's box: the whole hand, whose middle lies ahead of the palm's
MOST_LOGIT = 50.0


@dataclass(frozen=True, slots=True)
class Palm:
    """A palm in a picture: how sure (0 to 1), and the crop that holds the hand."""

    score: float
    crop: Crop


def anchors() -> Array:
    """The centres (2016, 2) of the detector's anchors, from 0 to 1."""
    found = []
    for cells, each in GRIDS:
        at = (np.arange(cells) + 0.5) / cells
        x, y = np.meshgrid(at, at)
        found.append(np.repeat(np.column_stack([x.ravel(), y.ravel()]), each, axis=0))
    return np.concatenate(found)


class PalmDetector:
    """Palms in a picture, the surest first."""

    def __init__(self, network: LandmarkNetwork) -> None:
        self._network, self._anchors = network, anchors()

    def find(self, image: Image) -> list[Palm]:
        """The palms of a BGR picture (H, W, 3)."""
        side = max(image.shape[:2])
        boxes, logits = self._network.run(_letterboxed(image, self._network.side_px))
        scores = 1.0 / (1.0 + np.exp(-np.clip(logits.reshape(-1).astype(float), -MOST_LOGIT, MOST_LOGIT)))
        likely = np.flatnonzero(scores >= LEAST_SCORE)
        points = boxes[likely].reshape(len(likely), 9, 2).astype(float) / self._network.side_px
        points[:, [0, *range(2, 9)]] += self._anchors[likely, None]
        offset = (np.array([image.shape[1], image.shape[0]]) - side) / 2
        return [_palm(float(score), palm * side, offset) for score, palm in _distinct(scores[likely], points)]


def _letterboxed(image: Image, size_px: int) -> NDArray[np.float32]:
    height, width = image.shape[:2]
    scale = size_px / max(height, width)
    small = cv2.resize(image, (round(scale * width), round(scale * height)), interpolation=cv2.INTER_AREA)
    square = np.zeros((size_px, size_px, 3), np.float32)
    top, left = (size_px - small.shape[0]) // 2, (size_px - small.shape[1]) // 2
    square[top : top + small.shape[0], left : left + small.shape[1]] = cv2.cvtColor(small, cv2.COLOR_BGR2RGB) / 255.0
    return square


def _distinct(scores: Array, points: Array) -> list[tuple[float, Array]]:
    """Overlapping detections (N, 9, 2) of the same palm as one: their mean, weighted by the score."""
    found, order = [], list(np.argsort(-scores))
    while order:
        overlapping = [k for k in order if _overlap(points[order[0]], points[k]) > OVERLAP or k == order[0]]
        weights = scores[overlapping]
        found.append((float(weights[0]), np.tensordot(weights / weights.sum(), points[overlapping], 1)))
        order = [k for k in order if k not in overlapping]
    return found


def _overlap(one: Array, other: Array) -> float:
    """The intersection of two boxes, each a centre and a size, over their union."""
    low = np.maximum(one[0] - one[1] / 2, other[0] - other[1] / 2)
    high = np.minimum(one[0] + one[1] / 2, other[0] + other[1] / 2)
    shared = float(np.prod(np.maximum(high - low, 0.0)))
    return shared / max(float(np.prod(one[1]) + np.prod(other[1])) - shared, 1e-9)


def _palm(score: float, palm: Array, offset: Array) -> Palm:
    """From a detection (9, 2) in px of the letterboxed square: centre, size, seven points."""
    angle = upright(palm[2 + WRIST], palm[2 + MIDDLE_KNUCKLE])
    side = float(palm[1].max())
    ahead = np.array([math.sin(angle), -math.cos(angle)])
    return Palm(score, Crop(palm[0] + offset + HAND_SHIFT * side * ahead, HAND_SCALE * side, angle))
