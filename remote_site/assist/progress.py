"""Whether the tool that is led comes nearer to its goal; pure."""

import math

from common.clock import NS_PER_MS

BEGIN_NS = 600 * NS_PER_MS  # the tool may lag behind the hand when it begins
PATIENCE_NS = 1500 * NS_PER_MS
NEARER_M, NEARER_RAD = 1e-3, math.radians(0.5)
LAG_M, LAG_RAD = 0.02, math.radians(10.0)  # more than a slow robot's at the speeds of a lead

Way = tuple[float, float]  # m and rad


class LeadProgress:
    """Notices a tool that falls behind its target, or comes no nearer to its goal."""

    def __init__(self, since_ns: int) -> None:
        self._since_ns = self._nearer_ns = since_ns
        self._left: Way = (math.inf, math.inf)

    def is_stuck(self, left: Way, lag: Way, now_ns: int) -> bool:
        """Take how far the tool is from the goal and from its present target; whether to give up."""
        if left[0] < self._left[0] - NEARER_M or left[1] < self._left[1] - NEARER_RAD:
            self._left, self._nearer_ns = left, now_ns
        arrives = left[0] < NEARER_M and left[1] < NEARER_RAD
        behind = now_ns - self._since_ns > BEGIN_NS and (lag[0] > LAG_M or lag[1] > LAG_RAD)
        return behind or (not arrives and now_ns - self._nearer_ns > PATIENCE_NS)
