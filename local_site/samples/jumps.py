"""Keeps a wrist that jumps out of the smoothing, so that one wrong frame does not spread over those after it; pure."""

import math
from typing import Protocol

from common.clock import NS_PER_S
from common.messages.hand import TrackingStatus
from local_site.tracking.tracker import ArmEstimate

BELIEVED = 3  # as many in a row are where the arm is now


class Smoother(Protocol):
    """Turns estimates of successive instants into calmer ones; causal, a LOST estimate makes it start anew.

    Covariances stay those of the single measurement: smoothing trades noise for lag, which they do not tell.
    """

    def smooth(self, estimate: ArmEstimate) -> ArmEstimate: ...


class JumpGate:
    """A `Smoother` before another: a wrist faster than `speed_m_s`, with `noise_m` to spare, passes by the other.

    The remote site refuses it as it is. With the third in a row the other starts anew there.
    """

    def __init__(self, smoother: Smoother, speed_m_s: float, noise_m: float) -> None:
        self._smoother, self._speed_m_s, self._noise_m = smoother, speed_m_s, noise_m
        self._last: ArmEstimate | None = None
        self._jumps = 0

    def smooth(self, estimate: ArmEstimate) -> ArmEstimate:
        """The estimate, smoothed unless its wrist jumps."""
        if self._jumped(estimate):
            self._jumps += 1
            if self._jumps < BELIEVED:
                return estimate
            self._smoother.smooth(ArmEstimate(estimate.t_ns, TrackingStatus.LOST, "the wrist has jumped"))
        self._last, self._jumps = estimate, 0
        return self._smoother.smooth(estimate)

    def _jumped(self, estimate: ArmEstimate) -> bool:
        if self._last is None or self._last.wrist is None or estimate.wrist is None:
            return False
        passed_s = (estimate.t_ns - self._last.t_ns) / NS_PER_S
        return math.dist(estimate.wrist, self._last.wrist) > self._speed_m_s * passed_s + self._noise_m
