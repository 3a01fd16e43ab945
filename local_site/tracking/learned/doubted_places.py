"""Where hands were seen that are hardly the operator's: without an arm, or of the other side."""

import numpy as np

from common.geometry import Array
from local_site.tracking.landmarks.hand_pairing import SeenHand

AROUND_M = 0.1
REMEMBERED = 8


class DoubtedPlaces:
    """Ranks hands by where they are: the first is one that was never doubted, then the one whose doubt is oldest."""

    def __init__(self) -> None:
        self._places: dict[int, Array] = {}
        self._doubts = 0

    def doubt(self, seen: SeenHand) -> int:
        """What speaks against a hand at its place: the number of the newest doubt, 0 without any."""
        return max(self._near(seen), default=0)

    @property
    def newest(self) -> int:
        """The number of the newest doubt about any hand, 0 without any."""
        return max(self._places, default=0)

    def add(self, seen: SeenHand) -> None:
        """Rather take any other hand from now on."""
        self.clear(seen)
        self._doubts += 1
        self._places[self._doubts] = seen.palm
        if len(self._places) > REMEMBERED:
            del self._places[min(self._places)]

    def move(self, seen: SeenHand) -> None:
        """The hand has moved on, and a doubt with it."""
        if doubt := self.doubt(seen):
            self._places[doubt] = seen.palm

    def clear(self, seen: SeenHand) -> None:
        """Nothing speaks against this hand any more."""
        for doubt in self._near(seen):
            del self._places[doubt]

    def _near(self, seen: SeenHand) -> list[int]:
        away = {doubt: float(np.linalg.norm(place - seen.palm)) for doubt, place in self._places.items()}
        return [doubt for doubt, away_m in away.items() if away_m < AROUND_M]
