"""How well the operator is known: side of the hand, size, the arm's lengths; and what may be reported with that."""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.tracking.config import LearnedConfig
from local_site.tracking.landmarks.hand_finder import SHORT_LOSS_NS
from local_site.tracking.landmarks.hand_pairing import SeenHand
from local_site.tracking.learned.doubted_places import DoubtedPlaces
from local_site.tracking.learned.hand_starts import right_by_shape, scale_of
from local_site.tracking.learned.shown_hand import ShownHand
from local_site.tracking.silhouette.arm_finder import SeenArm
from local_site.tracking.silhouette.joints import Body
from local_site.tracking.silhouette.operator_profile import MOST_PAIRS, OTHER_BODY_FRACTION, OperatorProfile
from local_site.tracking.tracker import TrackingReason

MOST_SPREAD = 0.06  # of the forearm's length: outlines that leak into the background vary more
MOST_INSTANTS = 2  # for each pair to learn from: where arms are found now and then, they may be anything
WRONG_LENGTH = 0.1
OTHER_SIZE = 0.2  # of a hand against the operator's: landmarks of one hand vary by half of it
REMEMBERED_SIZES = 60
CLEAR_SIDE = 0.8
OUTLINES_ALONE_NS = NS_PER_S // 2  # landmarks miss a turning hand for less
MOST_TRIALS = 2  # times the pairs to learn from, in which the hand of a profile does not fit


class Acquaintance:
    """Learns the operator, and decides from it which hand is the operator's and how sure a result is."""

    def __init__(self, config: LearnedConfig, profile: OperatorProfile | None) -> None:
        self._needed, self._right_arm = config.initial_pairs, config.right_arm
        self._hand, self._doubted = ShownHand(), DoubtedPlaces()
        self._sizes: deque[float] = deque(maxlen=REMEMBERED_SIZES)
        self._lengths: deque[tuple[int, float, float]] = deque(maxlen=config.initial_pairs)
        self._lesson, self._trials = TrackingReason.LEARNING, 0
        self.profile = profile
        self.body = Body(None if profile is None else profile.forearm_length_m)
        self.is_known = False

    @property
    def has_begun(self) -> bool:
        """Whether the hand that is seen has an arm."""
        return self._hand.has_begun

    @property
    def is_sure_of_side(self) -> bool:
        """Whether the hand has been seen long enough to be of the operator's side; an earlier one may look open."""
        return self._hand.side.is_sure

    @property
    def pairs(self) -> int:
        """From how many pairs of all runs the operator is known."""
        return min(self._needed + (0 if self.profile is None else self.profile.pairs), MOST_PAIRS)

    def doubt(self, seen: SeenHand) -> float:
        """What speaks against this being the operator's hand: 0 for nothing, infinite for another size.

        Instead of a hand that is doubted only one is tried that is clearly of the operator's side.
        """
        if self.is_known:
            size = scale_of(seen.points, self._right_arm) / float(np.median(self._sizes))
            if abs(size - 1) >= OTHER_SIZE:
                return math.inf
        doubt, newest = self._doubted.doubt(seen), self._doubted.newest
        is_clear = (seen.right if self._right_arm else 1.0 - seen.right) > CLEAR_SIDE
        return doubt if doubt or is_clear or not newest else newest + 1

    def has_side(self, t_ns: int, seen: SeenHand) -> bool:
        """Whether what has been seen of this hand so far, and now, may be a hand of the operator's side."""
        if not self._hand.has_begun and self._hand.is_another(t_ns, seen):
            self._hand = ShownHand()
            self._forget_unknown()
        right = seen.right if self.is_known else 0.5 * (seen.right + right_by_shape(seen.points))
        self._hand.see(t_ns, seen, right if self._right_arm else 1.0 - right)
        if not self.is_known:
            self._sizes.append(scale_of(seen.points, self._right_arm))
        self._doubted.move(seen)
        if self._hand.side.is_other:
            self._doubted.add(seen)
        return not self._hand.side.is_other

    def lacks_arm(self, seen: SeenHand) -> bool:
        """Whether this hand has shown no arm for so long that any other is rather the operator's from now on."""
        if self._hand.lacks_arm and not self.is_known:
            self.body = Body()  # that of the profile may be another's, whose length no arm fits
        if self._hand.has_begun or not self._hand.lacks_arm:
            return False
        self._doubted.add(seen)
        return True

    def was_seen(self, t_ns: int) -> bool:
        """Whether the operator's hand was seen so lately that the outlines before a dark wall are still its own."""
        return self.is_known and 0 <= t_ns - self._hand.seen_ns <= OUTLINES_ALONE_NS

    def has_length(self, arm: SeenArm, wrist: Array) -> bool:
        """Whether the forearm is as long as it was learned; true before that."""
        known = self.body.forearm_length
        return known is None or abs(_length(arm, wrist) / known - 1) < WRONG_LENGTH

    def learn(self, arm: SeenArm, wrist: Array, sleeve: Array | None, reasons: Sequence[TrackingReason]) -> None:
        """Take an arm that was found at the hand; `reasons` are doubts about its elbow."""
        self._hand.show_arm()
        if self._hand.has_begun and self._hand.last is not None:
            self._doubted.clear(self._hand.last)
        if self.is_known or reasons:
            return
        to_sleeve = math.nan if sleeve is None else float(np.linalg.norm(sleeve - arm.joints.elbow))
        self._lengths.append((self._hand.instants, _length(arm, wrist), to_sleeve))
        instants, forearms, sleeves = np.array(self._lengths).T
        forearm = float(np.median(forearms))
        spread = float(np.median(np.abs(forearms - forearm)))
        is_rare = np.ptp(instants) >= MOST_INSTANTS * self._needed
        if len(forearms) < self._needed or is_rare or spread > MOST_SPREAD * forearm:
            return
        if self.profile is not None and not self._is_body_of(self.profile, forearm):
            self.profile = None
        known = sleeves[np.isfinite(sleeves)]
        self.body, self.is_known = Body(forearm, float(np.median(known)) if len(known) else None), True

    def doubt_profile(self) -> None:
        """The hand at an arm is unclear: when it is so for long, the profile belongs to another body."""
        if self.profile is None or self.is_known:
            return
        self._trials += 1
        if self._trials > MOST_TRIALS * self._needed:
            self.profile, self.body, self._lesson = None, Body(), TrackingReason.OTHER_BODY
            self._forget_unknown()

    def status(self, reasons: Sequence[TrackingReason], elbow: str) -> tuple[TrackingStatus, str]:
        """How sure a result is, with `reasons` against the hand, and one against the elbow."""
        if not self._hand.side.is_sure or not self._hand.has_begun:
            return TrackingStatus.INITIALISING, elbow or self._lesson
        if not self.is_known:
            progress = f"{self._lesson} ({len(self._lengths)} of {self._needed} pairs)"
            doubts = [doubt for doubt in (*reasons, elbow) if doubt and doubt != TrackingReason.LEARNING]
            return TrackingStatus.DEGRADED, "; ".join([*doubts, progress])
        if self._hand.lacks_arm:
            return TrackingStatus.DEGRADED, "; ".join([*reasons, elbow or TrackingReason.NO_ARM])
        if reasons:
            return TrackingStatus.DEGRADED, "; ".join(reasons)
        return TrackingStatus.TRACKED, elbow

    def lose(self, t_ns: int) -> None:
        """No hand is seen: after a while another may be held up, which has to show its side and its arm again."""
        if not 0 <= t_ns - self._hand.seen_ns <= SHORT_LOSS_NS:
            self._hand = ShownHand()
            self._forget_unknown()

    def _is_body_of(self, profile: OperatorProfile, forearm_m: float) -> bool:
        size = float(np.median(self._sizes)) / profile.scale
        is_length = abs(forearm_m / profile.forearm_length_m - 1) <= OTHER_BODY_FRACTION
        return is_length and abs(size - 1) < OTHER_SIZE

    def _forget_unknown(self) -> None:
        """What was learned of a body that is not known yet may be another's."""
        if not self.is_known:
            self._sizes.clear()
            self._lengths.clear()


def _length(arm: SeenArm, wrist: Array) -> float:
    return float(np.linalg.norm(wrist - arm.joints.elbow))
