"""The fingers' order in a picture: of a hand seen from the side, the network may take the front for the back."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import project
from local_site.tracking.learned.hand_starts import PALM_LANDMARKS
from local_site.tracking.silhouette.hand_model.fit import HandView

THUMB = slice(1, 5)
FINGERS = slice(5, 21)
MOST_THUMB_OFF = 0.5  # of the palm's extent in the picture
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


def thumb_agrees(views: Sequence[HandView], points: Array) -> bool:
    """Whether the thumb of a hand with landmarks (21, 3) in m lies where all views tell it, unlike a mirrored one."""
    for view in views:
        if len(view.landmarks):
            pixels = project(view.projection, points)
            off = (view.landmarks - pixels)[THUMB]
            if np.sqrt(np.mean(np.sum(off * off, axis=1))) > MOST_THUMB_OFF * palm_extent(pixels):
                return False
    return True


def palm_extent(pixels: Array) -> float:
    """The diagonal in px of the palm's extent, by a hand's landmarks (21, 2)."""
    palm = pixels[list(PALM_LANDMARKS)]
    return float(np.linalg.norm(palm.max(axis=0) - palm.min(axis=0)))
