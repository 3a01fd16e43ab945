"""Discs in a picture: bright blobs on a darker ground, their centres to a fraction of a pixel, and their shape."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.pictures import as_grey

GROUND_PART = 7
MIN_AREA_PX = 8
MIN_CONTRAST = 12.0
MAX_DISCS = 200
EDGE_PX, RING_PX = 2, 4
ELLIPSE_SLACK = 0.35


@dataclass(frozen=True, slots=True)
class Disc:
    """Centre of gravity (2,) in px and covariance (2, 2) in px² of a disc's picture, an ellipse."""

    centre: Array
    covariance: Array


def find_discs(picture: Image) -> list[Disc]:
    """All whole elliptic blobs that are brighter than their surroundings; blobs cut off by the border are left out."""
    grey = as_grey(picture)
    side = max(15, min(grey.shape) // GROUND_PART) | 1
    lifted = cv2.morphologyEx(grey, cv2.MORPH_TOPHAT, np.ones((side, side), np.uint8))
    threshold, mask = cv2.threshold(lifted, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    if threshold < MIN_CONTRAST:
        return []
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    large = [k for k in range(1, count) if stats[k, cv2.CC_STAT_AREA] >= MIN_AREA_PX]
    large.sort(key=lambda k: -int(stats[k, cv2.CC_STAT_AREA]))
    found = [_measure(grey, labels, stats[k], k) for k in large[:MAX_DISCS]]
    return [disc for disc in found if disc is not None]


def _measure(grey: Image, labels: cv2.typing.MatLike, stats: cv2.typing.MatLike, label: int) -> Disc | None:
    """The blob as a disc, weighted with the part of each pixel that it covers; None if it is cut off or no ellipse."""
    left, top, width, height = (int(value) for value in stats[:4])
    if left == 0 or top == 0 or left + width == grey.shape[1] or top + height == grey.shape[0]:
        return None
    rows = slice(max(top - RING_PX - 1, 0), top + height + RING_PX + 1)
    columns = slice(max(left - RING_PX - 1, 0), left + width + RING_PX + 1)
    own = (labels[rows, columns] == label).astype(np.uint8)
    free = np.asarray((labels[rows, columns] == label) | (labels[rows, columns] == 0), dtype=np.bool_)
    weights = _weights(grey[rows, columns].astype(np.float64), own, free)
    v, u = np.nonzero(weights)
    w = weights[v, u]
    offsets = np.column_stack([u, v]).astype(np.float64)
    centre = w @ offsets / w.sum()
    covariance = (offsets - centre).T @ ((offsets - centre) * w[:, None]) / w.sum()
    ellipse = 4.0 * np.pi * float(np.sqrt(max(np.linalg.det(covariance), 0.0)))
    if not abs(float(w.sum()) / max(ellipse, 1e-9) - 1.0) < ELLIPSE_SLACK:
        return None
    return Disc(centre + np.array([columns.start, rows.start]), covariance)


def _weights(patch: Array, own: Image, free: NDArray[np.bool_]) -> Array:
    """How much of each pixel is disc, from its grey between the ground's around and the disc's own."""
    near = _grown(own, EDGE_PX)
    ring = (_grown(own, RING_PX) > 0) & (near == 0) & free
    ground = float(np.median(patch[ring])) if np.any(ring) else float(patch.min())
    inside = patch[own > 0]
    bright = float(np.quantile(inside, 0.75))
    result: Array = np.clip((patch - ground) / max(bright - ground, 1.0), 0.0, 1.0) * ((near > 0) & free)
    return result


def _grown(mask: Image, by_px: int) -> Image:
    side = 2 * by_px + 1
    shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return np.asarray(cv2.dilate(mask, shape), dtype=np.uint8)
