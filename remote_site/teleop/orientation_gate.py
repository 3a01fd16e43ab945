"""The orientation gate: the hand turns the tool only while it is seen, closed, and turns as a hand can; pure."""

import math

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, angle_between
from remote_site.safety.config import SafetyConfig


class OrientationGate:
    """Withholds the orientation while the hand opens, is open or closes, and after any turn too fast to be meant.

    A tip taken for another and an opening hand both look like a sudden turn. The orientation counts again once it has
    been calm for `turn_settle_ms`.
    """

    def __init__(self, config: SafetyConfig) -> None:
        self._fastest_rad_s = math.radians(config.hand_turn_deg_s)
        self._settle_ns = round(config.turn_settle_ms * NS_PER_MS)
        self._last: tuple[Array, int] | None = None
        self._calm_since_ns = 0

    def judge(self, operator_R_hand: Array | None, born_ns: int) -> Array | None:
        """The orientation (3 x 3) if it may act, None otherwise; `born_ns` rises from call to call."""
        if operator_R_hand is None:
            self._last = None
            return None
        if self._last is None or self._speed_rad_s(operator_R_hand, self._last, born_ns) > self._fastest_rad_s:
            self._calm_since_ns = born_ns
        self._last = operator_R_hand, born_ns
        return operator_R_hand if born_ns - self._calm_since_ns >= self._settle_ns else None

    @staticmethod
    def _speed_rad_s(operator_R_hand: Array, last: tuple[Array, int], born_ns: int) -> float:
        before, before_ns = last
        return angle_between(operator_R_hand, before) * NS_PER_S / max(born_ns - before_ns, 1)
