"""The hand's orientation as the tool follows it: later than the shown one where that is unsure; pure."""

import math
from collections import deque

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array, rotation_from_vector, vector_from_rotation
from remote_site.motion.catch_up import CATCH_UP_RAD_S
from remote_site.session.samples import Accepted
from remote_site.teleop.hold_offset import MOST_RAD, shortened

TAKEN_BACK_NS = 150 * NS_PER_MS
ACTED_KEPT = 64
# A swap of index and thumb turns the hand's frame by 180 deg, a thumb mirrored at the palm by about 90: what is made up
# stays nearer to no turn than to the smallest of these.
MOST_MADE_UP_RAD = math.radians(45.0)
NO_LAG = np.eye(3)


class FollowedOrientation:
    """Turns with the hand, no faster about each of its axes than a sample allows, and makes up slowly what it lacks.

    All samples count from the same reference: one that is withheld or followed slowly leaves a lag, but no drift. More
    than `MOST_MADE_UP_RAD` is not made up: that may be a finger taken for another. Withheld samples take back the last
    `TAKEN_BACK_NS` before them, since a wrong turn begins as a slow one.

    `spare` is the fraction of the catch-up speed that was not needed for the last sample.
    """

    def __init__(self) -> None:
        self.begin(None)

    def begin(self, operator_R_hand: Array | None) -> None:
        """Nothing is lacking: a new reference was taken at this orientation (3 x 3), None if the hand shows none."""
        self._shown, self._followed = operator_R_hand, operator_R_hand
        self._acted: deque[tuple[int, Array]] = deque(maxlen=ACTED_KEPT)
        self._back: Array | None = None
        self.spare = 1.0

    def follow(self, sample: Accepted, elapsed_s: float, spare: float = 1.0) -> Array | None:
        """The orientation to follow (3 x 3), `elapsed_s` after the last sample; None if none was shown yet.

        Of the catch-up speed only the fraction `spare` is available.
        """
        shown, followed = sample.operator_R_hand, self._followed
        self.spare = 1.0
        if followed is None:
            self._followed = shown
        else:
            most = [speed if speed == math.inf else speed * elapsed_s for speed in sample.turn_rad_s]
            self._followed = _turned(followed, self._aim(sample, followed, elapsed_s, spare), np.array(most))
        self._note(sample)
        return self._followed

    def resume(self, sample: Accepted) -> Array | None:
        """The orientation to follow after a hold, with the lag of before it: the tool is led there otherwise."""
        shown, followed = sample.operator_R_hand, self._followed
        if shown is not None and followed is not None:
            self._followed = shown @ self._lag(shown, followed)
        self._acted.clear()
        self._back = None
        self._note(sample)
        return self._followed

    @property
    def hand_R_followed(self) -> Array | None:
        """From the followed to the shown orientation (3 x 3); None while the hand shows none that counts."""
        if self._shown is None or self._followed is None:
            return None
        return NO_LAG if self._followed is self._shown else self._shown.T @ self._followed

    def _aim(self, sample: Accepted, followed: Array, elapsed_s: float, spare: float) -> Array:
        """Compute where to turn (3 x 3): with the shown hand, and less behind it; or back, while none is shown."""
        shown = sample.operator_R_hand
        if shown is None:
            self._take_back(sample.born_ns)
            return followed if self._back is None else self._back
        self._back = None
        lag = self._made_up(self._lag(shown, followed), elapsed_s, spare)
        return shown if lag is NO_LAG else shown @ lag

    def _lag(self, shown: Array, followed: Array) -> Array:
        """Compute what the tool lacks (3 x 3); after withheld samples it has kept its own, wherever the hand went."""
        lag = self.hand_R_followed
        return shown.T @ followed if lag is None else lag

    def _made_up(self, lag: Array, elapsed_s: float, spare: float) -> Array:
        """The lag (3 x 3), less what is made up in this time."""
        if lag is NO_LAG or elapsed_s <= 0.0:
            return lag
        vector = vector_from_rotation(lag)
        lacks = math.hypot(*vector)
        if lacks > MOST_MADE_UP_RAD:
            return lag
        left = MOST_RAD * shortened(vector / MOST_RAD, spare * CATCH_UP_RAD_S * elapsed_s / MOST_RAD)
        self.spare = 1.0 - (lacks - math.hypot(*left)) / (CATCH_UP_RAD_S * elapsed_s)
        return rotation_from_vector(left) if left.any() else NO_LAG

    def _take_back(self, born_ns: int) -> None:
        """Find where it was before the hold began, with the hold's first sample."""
        if self._acted:
            before = [rotation for t_ns, rotation in self._acted if t_ns <= born_ns - TAKEN_BACK_NS]
            self._back = before[-1] if before else self._acted[0][1]
            self._acted.clear()

    def _note(self, sample: Accepted) -> None:
        self._shown = sample.operator_R_hand
        if self._shown is not None and self._followed is not None:
            self._acted.append((sample.born_ns, self._followed))


def _turned(here: Array, there: Array, most: Array) -> Array:
    """From one orientation (3 x 3) towards another, at most so far (3,) in rad about each of its axes."""
    if np.isinf(most).all():
        return there
    way = vector_from_rotation(here.T @ there)
    kept = np.clip(way, -most, most)
    longest, length = float(most.max()), math.hypot(*kept)
    if length > longest:
        kept *= longest / length
    return there if np.array_equal(kept, way) else here @ rotation_from_vector(kept)
