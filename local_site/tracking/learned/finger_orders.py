"""The fingers' order in a picture: of a hand seen from the side, the network may take the front for the back."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import project
from local_site.tracking.learned.hand_starts import PALM_LANDMARKS
from local_site.tracking.silhouette.hand_model.fit import HandView

THUMB, INDEX = slice(1, 5), slice(5, 9)
FINGERS = slice(5, 21)
# Of the palm's extent in the picture; the nearest view tells an index that is fitted rightly within 0.18.
MOST_THUMB_OFF, MOST_INDEX_OFF = 0.5, 0.2
REVERSED = (0, 1, 2, 3, 4, 17, 18, 19, 20, 13, 14, 15, 16, 9, 10, 11, 12, 5, 6, 7, 8)


def reversed_fingers(landmarks: Array) -> Array:
    """Landmarks (21, 2) with the index taken for the little finger; the thumb's are NaN, for it was looked for on the
    wrong side."""
    other: Array = landmarks[list(REVERSED)]
    other[THUMB] = np.nan
    return other


def in_likely_order(view: HandView, expected: Array) -> HandView:
    """The view with its fingers in the order that lies nearer to landmarks expected (21, 2) in px."""
    if not len(view.landmarks):
        return view
    other = reversed_fingers(view.landmarks)
    as_told, turned_round = (float(np.sum((order - expected)[FINGERS] ** 2)) for order in (view.landmarks, other))
    return view._replace(landmarks=other) if turned_round < as_told else view


def possible_orders(views: Sequence[HandView]) -> list[list[HandView]]:
    """The views as the network tells them, then each time with another view's fingers reversed."""
    orders = [list(views)]
    for k, view in enumerate(views):
        if len(view.landmarks):
            other = view._replace(landmarks=reversed_fingers(view.landmarks))
            orders.append([*views[:k], other, *views[k + 1 :]])
    return orders


def is_as_told(views: Sequence[HandView], told: Sequence[HandView]) -> bool:
    """Whether the views have the landmarks that they were told with."""
    return all(view.landmarks is as_told.landmarks for view, as_told in zip(views, told, strict=True))


def thumb_agrees(views: Sequence[HandView], points: Array) -> bool:
    """Whether the thumb of a hand with landmarks (21, 3) in m lies where all views tell it, unlike a mirrored one."""
    return all(_has(THUMB, MOST_THUMB_OFF, view, points) for view in views if len(view.landmarks))


def is_contradicted(views: Sequence[HandView], points: Array) -> bool:
    """Whether no view with landmarks tells thumb or index where a hand with landmarks (21, 3) in m has it."""
    told = [view for view in views if len(view.landmarks)]
    fingers = ((THUMB, MOST_THUMB_OFF), (INDEX, MOST_INDEX_OFF))
    return bool(told) and any(not any(_has(*finger, view, points) for view in told) for finger in fingers)


def _has(finger: slice, most_off: float, view: HandView, points: Array) -> bool:
    """Whether a view tells a finger within a part of the palm's extent; true where it tells nothing of it."""
    pixels = project(view.projection, points)
    off = (view.landmarks - pixels)[finger]
    return not np.sqrt(np.mean(np.sum(off * off, axis=1))) > most_off * palm_extent(pixels)


def palm_extent(pixels: Array) -> float:
    """The diagonal in px of the palm's extent, by a hand's landmarks (21, 2)."""
    palm = pixels[list(PALM_LANDMARKS)]
    return float(np.linalg.norm(palm.max(axis=0) - palm.min(axis=0)))
