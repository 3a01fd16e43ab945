"""The orientation gate: the hand turns the tool only while it is seen, closed, and turns as a hand can; pure."""

import math
from collections import deque

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, angle_between
from remote_site.safety.config import SafetyConfig

TAKEN_BACK_NS = 150 * NS_PER_MS
ACTED_KEPT = 64


class OrientationGate:
    """Withholds the orientation while the hand opens, is open or closes, and after any turn too fast to be meant.

    A tip taken for another and an opening hand both look like a sudden turn, and begin as a slow one: so the first
    answer of a hold is the orientation of `TAKEN_BACK_NS` before. Rotation during a hold is discarded: the mapping
    continues from the present orientation once it has been calm for `turn_settle_ms`.
    """

    def __init__(self, config: SafetyConfig) -> None:
        self._fastest_rad_s = math.radians(config.hand_turn_deg_s)
        self._settle_ns = round(config.turn_settle_ms * NS_PER_MS)
        self._last: tuple[Array, int] | None = None
        self._calm_since_ns = 0
        self._acted: deque[tuple[int, Array]] = deque(maxlen=ACTED_KEPT)

    def judge(self, operator_R_hand: Array | None, born_ns: int, believed: float = 1.0) -> Array | None:
        """The orientation (3 x 3) if it may act, None otherwise; `born_ns` rises from call to call.

        `believed` is the fraction of the fastest turn that is accepted of an uncertain orientation.
        """
        if operator_R_hand is None:
            self._last = None
            return self._take_back(born_ns)
        fastest = believed * self._fastest_rad_s
        if self._last is None or self._speed_rad_s(operator_R_hand, self._last, born_ns) > fastest:
            self._calm_since_ns = born_ns
        self._last = operator_R_hand, born_ns
        if born_ns - self._calm_since_ns < self._settle_ns:
            return self._take_back(born_ns)
        self._acted.append((born_ns, operator_R_hand))
        return operator_R_hand

    def _take_back(self, born_ns: int) -> Array | None:
        """The orientation before the hold began, once; None from then on."""
        before = [rotation for t_ns, rotation in self._acted if t_ns <= born_ns - TAKEN_BACK_NS]
        self._acted.clear()
        return before[-1] if before else None

    @staticmethod
    def _speed_rad_s(operator_R_hand: Array, last: tuple[Array, int], born_ns: int) -> float:
        before, before_ns = last
        return angle_between(operator_R_hand, before) * NS_PER_S / max(born_ns - before_ns, 1)
