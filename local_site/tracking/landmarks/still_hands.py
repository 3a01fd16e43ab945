"""Hands that stand still: what looks like a hand may be a picture of one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from local_site.tracking.landmarks.hand_landmarks import HandLandmarks

STILL_NS = NS_PER_S
SAME_PLACE = 0.01  # of the crop's side: a poster's landmarks vary by 0.004, a hand held up moves more within a second
REMEMBERED = 8


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """The place (2,) in px where the middle of a hand of a view was seen first, and when."""

    view: int
    middle: Array
    since_ns: int


class StillHands:
    """Remembers where the views saw hands."""

    def __init__(self) -> None:
        self._places: list[_Place] = []

    def are_all(self, t_ns: int, hands: Sequence[Sequence[HandLandmarks]]) -> bool:
        """Return whether each of these hands, by view, has been where it is now for long."""
        seen = [self._place(t_ns, view, hand) for view, found in enumerate(hands) for hand in found]
        others = [place for place in self._places if place not in seen]
        self._places = [*others, *seen][-REMEMBERED:]
        return all(t_ns - place.since_ns >= STILL_NS for place in seen)

    def _place(self, t_ns: int, view: int, hand: HandLandmarks) -> _Place:
        middle = hand.points.mean(axis=0)
        for place in self._places:
            away_px = float(np.linalg.norm(place.middle - middle))
            if place.view == view and away_px < SAME_PLACE * hand.crop.side_px:
                return place
        return _Place(view, middle, t_ns)
