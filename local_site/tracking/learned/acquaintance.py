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
from local_site.tracking.landmarks.side_evidence import SideEvidence
from local_site.tracking.learned.hand_starts import right_by_shape, scale_of
from local_site.tracking.silhouette.arm_finder import SeenArm
from local_site.tracking.silhouette.joints import Body
from local_site.tracking.silhouette.operator_profile import MOST_PAIRS, OTHER_BODY_FRACTION, OperatorProfile
from local_site.tracking.tracker import TrackingReason

BEGUN = 3  # pairs with an arm at the hand, before any point may be used: a hand on a poster has none
MOST_SPREAD = 0.06  # of the forearm's length: outlines that leak into the background vary more
WRONG_LENGTH = 0.1
OTHER_SIZE = 0.2  # of a hand against the operator's: landmarks of one hand vary by half of it
REMEMBERED_SIZES = 60
WITHOUT_ARM_NS = NS_PER_S  # a hand whose arm is not found for longer may be another's


class Acquaintance:
    """Learns the operator, and decides from it which hand is the operator's and how sure a result is."""

    def __init__(self, config: LearnedConfig, profile: OperatorProfile | None) -> None:
        self._needed, self._right_arm, self._profile = config.initial_pairs, config.right_arm, profile
        self._side = SideEvidence()
        self._sizes: deque[float] = deque(maxlen=REMEMBERED_SIZES)
        self._lengths: deque[tuple[float, float]] = deque(maxlen=config.initial_pairs)
        self._agreed = 0
        self._seen_ns = self._arm_ns = 0
        self.body = Body(None if profile is None else profile.forearm_length_m)
        self.is_known = False

    @property
    def pairs(self) -> int:
        """From how many pairs of all runs the operator is known."""
        return min(self._needed + (0 if self._profile is None else self._profile.pairs), MOST_PAIRS)

    def may_be(self, seen: SeenHand) -> bool:
        """Whether this may be the operator's hand, by its size."""
        if not self.is_known:
            return True
        return abs(scale_of(seen.points, self._right_arm) / float(np.median(self._sizes)) - 1) < OTHER_SIZE

    def has_side(self, t_ns: int, seen: SeenHand) -> bool:
        """Whether what has been seen so far, and now, may be a hand of the operator's side."""
        self._seen_ns = t_ns
        right = seen.right if self.is_known else 0.5 * (seen.right + right_by_shape(seen.points))
        self._side.add(right if self._right_arm else 1.0 - right)
        if not self.is_known:
            self._sizes.append(scale_of(seen.points, self._right_arm))
        return not self._side.is_other

    def has_length(self, arm: SeenArm, wrist: Array) -> bool:
        """Whether the forearm is as long as it was learned; true before that."""
        known = self.body.forearm_length
        return known is None or abs(_length(arm, wrist) / known - 1) < WRONG_LENGTH

    def learn(self, arm: SeenArm, wrist: Array, sleeve: Array | None, reasons: Sequence[TrackingReason]) -> None:
        """Take an arm that was found at the hand; `reasons` are doubts about its elbow."""
        self._agreed += 1
        self._arm_ns = self._seen_ns
        if self.is_known or reasons:
            return
        to_sleeve = math.nan if sleeve is None else float(np.linalg.norm(sleeve - arm.joints.elbow))
        self._lengths.append((_length(arm, wrist), to_sleeve))
        forearms, sleeves = np.array(self._lengths).T
        forearm = float(np.median(forearms))
        spread = float(np.median(np.abs(forearms - forearm)))
        if len(forearms) < self._needed or spread > MOST_SPREAD * forearm:
            return
        if self._profile is not None and abs(forearm / self._profile.forearm_length_m - 1) > OTHER_BODY_FRACTION:
            self._profile = None
        known = sleeves[np.isfinite(sleeves)]
        self.body, self.is_known = Body(forearm, float(np.median(known)) if len(known) else None), True

    def status(self, reasons: Sequence[TrackingReason], elbow: str) -> tuple[TrackingStatus, str]:
        """How sure a result is, with `reasons` against the hand, and one against the elbow."""
        if not self._side.is_sure or self._agreed < BEGUN:
            return TrackingStatus.INITIALISING, elbow or TrackingReason.LEARNING
        if not self.is_known:
            progress = f"{TrackingReason.LEARNING} ({len(self._lengths)} of {self._needed} pairs)"
            doubts = [doubt for doubt in (*reasons, elbow) if doubt and doubt != TrackingReason.LEARNING]
            return TrackingStatus.DEGRADED, "; ".join([*doubts, progress])
        if self._seen_ns - self._arm_ns > WITHOUT_ARM_NS:
            return TrackingStatus.DEGRADED, "; ".join([*reasons, elbow or TrackingReason.NO_ARM])
        if reasons:
            return TrackingStatus.DEGRADED, "; ".join(reasons)
        return TrackingStatus.TRACKED, elbow

    def lose(self, t_ns: int) -> None:
        """No hand is seen: after a while another may be held up, which has to show its side and its arm again."""
        if t_ns - self._seen_ns > SHORT_LOSS_NS:
            self._side.forget()
            self._agreed = 0


def _length(arm: SeenArm, wrist: Array) -> float:
    return float(np.linalg.norm(wrist - arm.joints.elbow))
