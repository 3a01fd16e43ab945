"""Convex hulls of points and their filling, to the pixel as by OpenCV, many at once: a call for each costs far more."""

import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from local_site.kernels.compiled import compiled

FixedPoints = NDArray[np.int32]
Numbers = NDArray[np.int64]

BITS = 16  # of a pixel, with which OpenCV follows an edge
HALF = 1 << (BITS - 1)
HIGH = 32  # bits up, where a point's y goes before its x to be sorted


@compiled
def convex_hulls(points: FixedPoints, ends: Numbers) -> tuple[Numbers, Numbers]:
    """The corners (M, 2) of the hulls of groups of points (N, 2), one group after the other, each of which ends at its
    `ends` (K,), and where the hulls end likewise.

    A hull begins with its uppermost corner and goes down its right side first.
    """
    corners, hull_ends = np.empty((2 * len(points), 2), np.int64), np.empty(len(ends), np.int64)
    start = count = 0
    for k in range(len(ends)):
        keys = np.empty(ends[k] - start, np.int64)
        for n in range(len(keys)):
            keys[n] = (np.int64(points[start + n, 1]) << HIGH) + points[start + n, 0]
        keys.sort()
        start = ends[k]
        count = _add_side(keys, corners, count)
        count = _add_side(keys[::-1], corners, count)
        hull_ends[k] = count
    return corners[:count], hull_ends


@compiled
def _add_side(keys: Numbers, corners: Numbers, first: int) -> int:
    """Add one side of a hull but its end, from its sorted points; returns how many corners there are then."""
    count = first
    for n in range(len(keys)):
        y = (keys[n] + (1 << (HIGH - 1))) >> HIGH
        x = keys[n] - (y << HIGH)
        while count > first + 1:
            ax, ay, bx, by = corners[count - 2, 0], corners[count - 2, 1], corners[count - 1, 0], corners[count - 1, 1]
            if (bx - ax) * (y - ay) > (by - ay) * (x - ax):
                break
            count -= 1
        corners[count, 0], corners[count, 1] = x, y
        count += 1
    return count - 1


@compiled
def fill_hulls(picture: Image, corners: Numbers, ends: Numbers, levels: Image, shift: int) -> None:
    """Fill hulls as they were found in a picture (H, W), each at its level (K,), as `cv2.fillConvexPoly` does with
    `shift`; but for where an outline leaves the picture, there to within a pixel."""
    height, width = picture.shape
    left, right = np.empty(height, np.int64), np.empty(height, np.int64)
    start = 0
    for k in range(len(ends)):
        hull = corners[start : ends[k]] << (BITS - shift)
        start = ends[k]
        top, bottom = max(_row(hull[0, 1]), 0), min(_row(hull[:, 1].max()), height - 1)
        left[top : bottom + 1], right[top : bottom + 1] = width, -1
        x0, y0 = hull[-1, 0], hull[-1, 1]
        for n in range(len(hull)):
            x1, y1 = hull[n, 0], hull[n, 1]
            if abs(x1 - x0) > abs(y1 - y0):
                _flat_line(x0, y0, x1, y1, left, right)
            else:
                _steep_line(x0, y0, x1, y1, left, right)
            _side(x0, y0, x1, y1, left, right)
            x0, y0 = x1, y1
        for y in range(top, bottom + 1):
            picture[y, max(left[y], 0) : right[y] + 1] = levels[k]


@compiled
def _row(y: int) -> int:
    """The pixel in which this is, also of a column."""
    return (y + HALF) >> BITS


@compiled
def _widen(y: int, first: int, last: int, left: Numbers, right: Numbers) -> None:
    if 0 <= y < len(left):
        left[y], right[y] = min(left[y], first), max(right[y], last)


@compiled
def _flat_line(x0: int, y0: int, x1: int, y1: int, left: Numbers, right: Numbers) -> None:
    """Widen the rows by a line with a pixel in each column."""
    if x1 < x0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    slope = int(((y1 - y0) << BITS) / ((x1 - x0) | 1))
    first, y, row = _row(x0), y0 + HALF, _row(y0)
    end = first + ((x1 - x0) >> BITS) + 1
    _widen(_row(y1), _row(x1), _row(x1), left, right)
    for x in range(first, end):
        if y >> BITS != row:
            _widen(row, first, x - 1, left, right)
            row, first = y >> BITS, x
        y += slope
    _widen(row, first, end - 1, left, right)


@compiled
def _steep_line(x0: int, y0: int, x1: int, y1: int, left: Numbers, right: Numbers) -> None:
    """Widen the rows by a line with a pixel in each row."""
    if y1 < y0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    slope = int(((x1 - x0) << BITS) / ((y1 - y0) | 1))
    _widen(_row(y1), _row(x1), _row(x1), left, right)
    _widen_all(_row(y0), _row(y0) + ((y1 - y0) >> BITS) + 1, x0 + HALF, slope, left, right)


@compiled
def _side(x0: int, y0: int, x1: int, y1: int, left: Numbers, right: Numbers) -> None:
    """Widen the rows by the end of what is filled between both sides."""
    if y1 < y0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    top, end = _row(y0), _row(y1)
    if top < end:
        _widen_all(top, end, x0 + HALF, int((2 * (x1 - x0) + (end - top)) / (2 * (end - top))), left, right)


@compiled
def _widen_all(top: int, end: int, x: int, slope: int, left: Numbers, right: Numbers) -> None:
    """Widen the rows from the top to before the end, the first of them to x, each by the slope further."""
    x -= min(top, 0) * slope
    for y in range(max(top, 0), min(end, len(left))):
        left[y], right[y] = min(left[y], x >> BITS), max(right[y], x >> BITS)
        x += slope
