"""Rough positions of shoulder end, elbow, wrist and finger tips in a silhouette, from this image alone.

Distances are geodesic: layers of equal distance from the shoulder end cross the arm, so that their centroids are its
medial axis in any pose, and the largest distance to the background within a layer is the arm's half width there.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.features.silhouette import Silhouette

WORKING_SIZE = 112
MIN_LAYERS = 16
END_REACH = 1.6
HAND_RADII = (2.5, 7.0)
DEFAULT_HAND_RADII = 4.2


@dataclass(frozen=True, slots=True)
class Posture:
    """Rough pixel positions (2,) of the joints and ends of the arm, and its half width in px."""

    shoulder_end: Array
    elbow: Array
    wrist: Array
    hand_end: Array
    half_width: float

    @property
    def points(self) -> tuple[Array, Array, Array, Array]:
        """The joints and ends, from the shoulder on."""
        return self.shoulder_end, self.elbow, self.wrist, self.hand_end


def find_posture(silhouette: Silhouette) -> Posture | None:
    """The posture of an arm with hand and shoulder end in view, or None if the blob has no such shape."""
    mask, scale, origin = _working_mask(silhouette)
    radii = np.asarray(cv2.distanceTransform(mask, cv2.DIST_L2, 3), dtype=np.float64)
    y, x = np.unravel_index(int(np.argmax(radii)), radii.shape)
    first = _farthest(mask, (int(x), int(y)))
    ends = first, _farthest(mask, first)  # the two pixels farthest from each other within the arm
    border = _border_pixel(silhouette, scale, origin)
    start = _blunt(ends, radii)
    if border is not None and mask[border[1], border[0]]:
        away = max(ends, key=lambda end: math.hypot(end[0] - border[0], end[1] - border[1]))
        if _blunt((border, away), radii) != border:
            return None
        start = border
    axis = _medial_axis(mask, radii, start)
    if axis is None:
        return None
    points, half_widths = axis
    wrist = _wrist(points, half_widths)
    elbow = _bend(points[: wrist + 1])
    if elbow is None:
        return None
    shoulder, bend, neck, tip = ((points[k] + 0.5) * scale - 0.5 + origin for k in (0, elbow, wrist, -1))
    return Posture(shoulder, bend, neck, tip, float(half_widths[: wrist + 1].max()) * scale)


def _working_mask(silhouette: Silhouette) -> tuple[NDArray[np.uint8], float, Array]:
    """The filled blob at working size with a black border, the px per working px, and the px of its corner."""
    contour = silhouette.contour.astype(np.int32)
    x, y, width, height = cv2.boundingRect(contour)
    filled = np.zeros((height, width), dtype=np.uint8)
    cv2.drawContours(filled, [contour - (x, y)], -1, 255, cv2.FILLED)
    scale = max(1.0, max(width, height) / WORKING_SIZE)
    size = (max(1, round(width / scale)), max(1, round(height / scale)))
    small = np.where(cv2.resize(filled, size, interpolation=cv2.INTER_AREA) > 127, 255, 0).astype(np.uint8)
    rimmed = cv2.copyMakeBorder(small, 1, 1, 1, 1, cv2.BORDER_CONSTANT)
    return np.asarray(rimmed, dtype=np.uint8), scale, np.array([x - scale, y - scale])


def _border_pixel(silhouette: Silhouette, scale: float, origin: Array) -> tuple[int, int] | None:
    """The working pixel at the middle of the arm's contact with the image border, or None without contact."""
    touching = silhouette.contour[silhouette.touches_border(silhouette.contour)]
    if not len(touching):
        return None
    nearest = touching[np.argmin(np.sum((touching - touching.mean(axis=0)) ** 2, axis=1))]
    x, y = np.floor((nearest - origin) / scale).astype(int)
    return int(x), int(y)


@compiled
def _layers(mask: NDArray[np.uint8], start: tuple[int, int]) -> NDArray[np.int32]:
    """Geodesic distance in steps within the mask from a pixel (x, y), -1 where unreachable; the mask's border is 0.

    Steps go alternately to four and to eight neighbours, so that layers of equal distance are nearly round.
    """
    layer = np.full(mask.shape, -1, np.int32)
    queue = np.empty((mask.size, 2), np.int32)
    if mask[start[1], start[0]] == 0:
        return layer
    layer[start[1], start[0]] = 0
    queue[0] = start
    # `fresh` starts the pixels of the last round, `old` those of the round before, whose diagonal steps are still due
    old, fresh, count, rounds = 0, 0, 1, 0
    while old < count:
        rounds += 1
        corners = rounds % 2 == 0
        begin, end = old if corners else fresh, count
        for k in range(begin, end):
            x, y = queue[k]
            for dy in range(-1, 2):
                for dx in range(-1, 2):
                    if (corners or dx * dy == 0) and mask[y + dy, x + dx] and layer[y + dy, x + dx] < 0:
                        layer[y + dy, x + dx] = rounds
                        queue[count] = x + dx, y + dy
                        count += 1
        old, fresh = fresh, end
    return layer


def _farthest(mask: NDArray[np.uint8], start: tuple[int, int]) -> tuple[int, int]:
    layer = _layers(mask, start)
    y, x = np.unravel_index(int(np.argmax(layer)), layer.shape)
    return int(x), int(y)


def _blunt(ends: tuple[tuple[int, int], tuple[int, int]], radii: Array) -> tuple[int, int]:
    """The end where the arm is as wide as a limb, at sleeve or shoulder; fingers are narrow."""
    reach = END_REACH * float(radii.max())
    y, x = np.indices(radii.shape)
    widest = [float(radii[np.hypot(x - ex, y - ey) < reach].max(initial=0.0)) for ex, ey in ends]
    return ends[int(np.argmax(widest))]


def _medial_axis(mask: NDArray[np.uint8], radii: Array, start: tuple[int, int]) -> tuple[Array, Array] | None:
    """The medial axis from shoulder end to hand end: K centroids (K, 2) and half widths (K,) in working px."""
    layers = _layers(mask, start)
    inside = layers >= 0
    layer = layers[inside]
    size = np.bincount(layer)
    y, x = np.nonzero(inside)
    kept = size > 0
    if np.count_nonzero(kept) < MIN_LAYERS:
        return None
    points = np.column_stack([np.bincount(layer, weights=v)[kept] / size[kept] for v in (x, y)])
    widest = np.zeros(len(size))
    np.maximum.at(widest, layer, radii[inside])
    smooth = cv2.blur(widest[kept][None, :], (3, 1), borderType=cv2.BORDER_REPLICATE)[0]
    return points, np.asarray(smooth, dtype=np.float64)


def _wrist(points: Array, half_widths: Array) -> int:
    """The layer of the neck between forearm and palm, within a hand's length of the tips."""
    steps = np.append(np.linalg.norm(np.diff(points, axis=0), axis=1)[::-1].cumsum()[::-1], 0.0)
    widest = float(half_widths[: max(1, len(half_widths) // 2)].max())
    low, high = (limit * widest for limit in HAND_RADII)
    palm = np.maximum.accumulate(half_widths[::-1])[::-1]
    arm = np.maximum.accumulate(half_widths)
    depth = np.minimum(palm, arm) - half_widths
    allowed = (steps > low) & (steps < min(high, 0.6 * steps[0]))
    if allowed.any() and float(depth[allowed].max()) > 0.02 * widest:
        return int(np.argmax(np.where(allowed, depth, -1.0)))
    return int(np.argmin(np.abs(steps - min(DEFAULT_HAND_RADII * widest, 0.45 * steps[0]))))


def _bend(points: Array) -> int | None:
    """The index that splits a path (K, 2) best into two straight pieces, in O(K) by cumulative sums."""
    margin = max(3, len(points) // 8)
    if len(points) < 4 * margin:
        return None
    before = _line_residuals(points)
    after = _line_residuals(points[::-1])[::-1]
    total = (before + after)[margin:-margin]
    return margin + int(np.argmin(total))


def _line_residuals(points: Array) -> Array:
    """Sum of squared distances of points[: k + 1] from their best line, for every k."""
    shifted = points - points[0]
    n = np.arange(1.0, len(points) + 1.0)
    x, y = shifted.T
    xx, yy, xy = (np.cumsum(v) for v in (x * x, y * y, x * y))
    mx, my = np.cumsum(x) / n, np.cumsum(y) / n
    a, b, c = xx - n * mx * mx, xy - n * mx * my, yy - n * my * my
    residuals: Array = 0.5 * (a + c) - np.sqrt(0.25 * (a - c) ** 2 + b * b)
    return residuals
