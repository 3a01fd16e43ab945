"""Landmarks from the width of a limb along its axis: its middle, where the palm begins, where the limb ends.

Rows are positions t (R,) in px along the axis and the edges' offsets (R,) across it, NaN where an edge is not seen.
"""

import math

import numpy as np

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.features.medial import typical_width

NECK_WINDOW = 1.2
NECK_SMOOTHING = 5
PALM_GROWTH = 1.1
PALM_BEGINS = 0.06
WIDTH_CHANGE = 0.25
TYPICAL_HALF_WIDTHS = 1.5
SURE_PX = 3.0


@compiled
def mean_between(t: Array, lower: Array, upper: Array, start: float, end: float) -> tuple[int, float, float]:
    """Of the clean rows between two positions: their number, mean position and mean middle in px."""
    rows, position, middle = 0, 0.0, 0.0
    for k in range(len(t)):
        if start <= t[k] <= end and not math.isnan(lower[k]):
            rows, position = rows + 1, position + t[k]
            middle += 0.5 * (upper[k] + lower[k])
    return rows, position / max(rows, 1), middle / max(rows, 1)


@compiled
def palm_begin(t: Array, lower: Array, upper: Array, length: float, half_width: float) -> float:
    """The position of the wrist along the axis, from where the palm widens beyond the neck; NaN if it does not.

    The joint lies a small fraction of the forearm's length before that.
    """
    smooth = _smooth_width(lower, upper, 4 * half_width)
    first, last = -1, -1
    for k in range(len(t)):
        if abs(t[k] - length) < NECK_WINDOW * half_width:
            first, last = k if first < 0 else first, k
    if first < 0 or last - first + 1 < NECK_SMOOTHING:
        return math.nan
    neck = first + int(np.argmin(smooth[first : last + 1]))
    if neck == first:
        return math.nan
    limit = PALM_GROWTH * smooth[neck]
    for k in range(neck + 1, len(t)):
        if smooth[k] > limit:
            step = (limit - smooth[k - 1]) / (smooth[k] - smooth[k - 1])
            return float(t[k - 1] + step - PALM_BEGINS * length)
    return math.nan


@compiled
def _smooth_width(lower: Array, upper: Array, unseen: float) -> Array:
    """The widths (R,) averaged over neighbouring rows; rows without edges count as `unseen` px."""
    count, reach = len(lower), NECK_SMOOTHING // 2
    smooth = np.zeros(count)
    for k in range(count):
        for j in range(k - reach, k + reach + 1):
            width = upper[min(max(j, 0), count - 1)] - lower[min(max(j, 0), count - 1)]
            smooth[k] += (unseen if math.isnan(width) else width) / NECK_SMOOTHING
    return smooth


@compiled
def limb_span(t: Array, lower: Array, upper: Array, start: float, half_width: float) -> tuple[float, float]:
    """The first and last position along its axis, after `start`, between which the limb keeps its width.

    Near the crease, where it meets the other limb, rows are wider than the limb.
    """
    first = -1
    for k in range(len(t)):
        if t[k] > start and not math.isnan(lower[k]):
            first = k
            break
    if first < 0:
        return start, start
    typical = typical_width(t, lower, upper, t[first], t[first] + TYPICAL_HALF_WIDTHS * half_width)
    begin = -1
    for k in range(first, len(t)):
        kept = abs((upper[k] - lower[k]) / typical - 1) < WIDTH_CHANGE
        if kept and begin < 0:
            begin = k
        elif not kept and begin >= 0 and t[k] > t[begin] + SURE_PX:
            return float(t[begin]), float(t[k])
    return float(t[max(begin, first)]), float(t[-1])
