"""What one hand has shown since it was first seen: which side it is of, and how often an arm was at it."""

import numpy as np

from common.clock import NS_PER_S
from local_site.tracking.landmarks.hand_finder import MOST_JUMP_M, MOST_SPEED
from local_site.tracking.landmarks.hand_pairing import SeenHand
from local_site.tracking.landmarks.side_evidence import SideEvidence

BEGUN = 3  # pairs with an arm at the hand, before any point may be used: a hand on a poster has none
WITHOUT_ARM_NS = NS_PER_S  # a hand whose arm is not found for longer may be another's


class ShownHand:
    """One hand from its first sight to its loss."""

    def __init__(self) -> None:
        self.side = SideEvidence()
        self.last: SeenHand | None = None
        self.seen_ns = self._arm_ns = self.instants = self._arms = 0

    @property
    def has_begun(self) -> bool:
        """Whether it has an arm."""
        return self._arms >= BEGUN

    @property
    def lacks_arm(self) -> bool:
        """Whether no arm has been at it for long."""
        return self.seen_ns - self._arm_ns > WITHOUT_ARM_NS

    def is_another(self, t_ns: int, seen: SeenHand) -> bool:
        """Whether this hand is too far off to be the same one."""
        if self.last is None:
            return False
        away_m = float(np.linalg.norm(seen.palm - self.last.palm))
        return away_m > MOST_JUMP_M + MOST_SPEED * max(0, t_ns - self.seen_ns) / NS_PER_S

    def see(self, t_ns: int, seen: SeenHand, for_side: float) -> None:
        """Take what one instant shows, from 0 to 1 of the operator's side."""
        if self.last is None:
            self._arm_ns = t_ns
        self.seen_ns, self.last = t_ns, seen
        self.instants += 1
        self.side.add(for_side)

    def show_arm(self) -> None:
        """An arm is at the hand that was seen last."""
        self._arms += 1
        self._arm_ns = self.seen_ns
