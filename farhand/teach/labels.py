"""Labels of points in a picture: one for points that lie together, none over another, near what they name; pure."""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np

from common.geometry import Array

MOST_LABELS = 40
WIDER = 1.3  # by how much more apart points are taken together where there are too many labels
GAP, DISTANCES, DIRECTIONS = 4.0, (9.0, 16.0, 26.0, 42.0, 62.0, 90.0), 16
OVER_LABEL, OVER_POINT, OUTSIDE, AWAY = 100.0, 1.0, 100.0, 0.02  # what a place costs: how much, how many, how far


class LabelBox(NamedTuple):
    """A part of the picture, from its lower left to its upper right corner."""

    left: float
    bottom: float
    right: float
    top: float


def taken_together(points: Array, within: float) -> list[list[int]]:
    """Which points (n, 2) have one label, each group by its first point: those nearer to that one than `within`.

    Where there would be more labels than a person reads, points farther apart have one, too.
    """
    groups: list[list[int]] = []
    for k, point in enumerate(points):
        near = (group for group in groups if np.linalg.norm(points[group[0]] - point) < within)
        if (group := next(near, None)) is not None:
            group.append(k)
        else:
            groups.append([k])
    return groups if len(groups) <= MOST_LABELS else taken_together(points, WIDER * within)


def in_words(numbers: Sequence[int]) -> str:
    """Rising numbers as a person writes them: 3–5, 9."""
    runs = [[n for _, n in run] for _, run in groupby(enumerate(numbers), key=lambda pair: pair[1] - pair[0])]
    return ", ".join(f"{run[0]}–{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)


def placed(anchors: Array, sizes: Array, points: Array, room: LabelBox) -> list[LabelBox]:
    """Place labels of these sizes (n, 2), each beside its anchor (n, 2), within the room.

    Of the places around an anchor each takes the one that covers no label, as few of the `points` (m, 2) as possible,
    and is near; where there is none without a label, the one that covers least.
    """
    found: list[LabelBox] = []
    for anchor, size in zip(anchors, sizes, strict=True):
        places = _places(anchor, size)
        costs = [_cost(place, anchor, found, points, room) for place in places]
        found.append(places[int(np.argmin(costs))])
    return found


def overlap(a: LabelBox, b: LabelBox) -> float:
    """The area that two rectangles share."""
    width = min(a.right, b.right) - max(a.left, b.left)
    height = min(a.top, b.top) - max(a.bottom, b.bottom)
    return max(width, 0.0) * max(height, 0.0)


def _places(anchor: Array, size: Array) -> list[LabelBox]:
    """All around an anchor, the nearest first, to the right and up before elsewhere."""
    angles = np.pi / 4 + 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    found = []
    for distance in DISTANCES:
        for across, up in zip(np.cos(angles), np.sin(angles), strict=True):
            x, y = anchor + (distance + 0.5 * size) * (across, up)
            found.append(LabelBox(x - size[0] / 2, y - size[1] / 2, x + size[0] / 2, y + size[1] / 2))
    return found


def _cost(place: LabelBox, anchor: Array, others: Sequence[LabelBox], points: Array, room: LabelBox) -> float:
    wide = LabelBox(place.left - GAP, place.bottom - GAP, place.right + GAP, place.top + GAP)
    area = (wide.right - wide.left) * (wide.top - wide.bottom)
    covered = sum(overlap(wide, other) for other in others) / area
    outside = 1.0 - overlap(wide, room) / area
    inside = (points > (wide.left, wide.bottom)) & (points < (wide.right, wide.top))
    middle = np.array([place.left + place.right, place.bottom + place.top]) / 2
    away = float(np.linalg.norm(middle - anchor))
    return OVER_LABEL * covered + OUTSIDE * outside + OVER_POINT * int(inside.all(axis=1).sum()) + AWAY * away
