"""Check that the arm follows: what it measures against all that was written within the robot's lag; pure."""

from collections import deque

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.drivers.driver import Capabilities
from remote_site.drivers.faults import FaultCode, RobotFault

MARGIN_NS = 50 * NS_PER_MS  # the age of a reading, and turns of this process that come late
# Nine times the worst that was measured at full speed, 3.1 rad/s: none of the kinematic and the emulated A465's arm,
# 0.011 rad of the simulated one, which runs a little ahead. Twice as far as an arm may be from where it is activated.
TOLERANCE_RAD = 0.1
PATIENCE_NS = 100 * NS_PER_MS  # three readings of a slow robot: one alone is no proof


class FollowingCheck:
    """Every measured joint has to lie between the least and the largest position written within `lag_ns`.

    An arm that follows late is within that hull at any speed; one that is held, or goes its own way, leaves it.
    """

    def __init__(self, capabilities: Capabilities, names: tuple[str, ...]) -> None:
        self.lag_ns = round(capabilities.longest_lag_s * NS_PER_S) + MARGIN_NS
        self._names = names
        self._written: deque[tuple[int, Array]] = deque()
        self._apart_ns: int | None = None

    def restart(self, q: Array, now_ns: int) -> None:
        """Begin at rest at `q` (n,) in rad."""
        self._written.clear()
        self._written.append((now_ns, q))
        self._apart_ns = None

    def note(self, q: Array, now_ns: int) -> None:
        """`q` (n,) in rad is what was written last."""
        if q is not self._written[-1][1]:
            self._written.append((now_ns, q))
        while len(self._written) > 1 and self._written[1][0] <= now_ns - self.lag_ns:
            self._written.popleft()  # it was replaced before the lag began

    def excess(self, q: Array) -> Array:
        """Compute how far each measured joint (n,) is outside what was written within the lag, rad; negative inside."""
        least, greatest = self._hull()
        beyond: Array = np.maximum(least - q, q - greatest)
        return beyond

    def outside(self, q: Array) -> str:
        """Say which joint of `q` (n,) rad is farthest outside what was written within the lag, and where both are."""
        k, (least, greatest) = int(self.excess(q).argmax()), self._hull()
        commanded = f"{least[k]:.3f} to {greatest[k]:.3f} rad was commanded"
        return (
            f"{self._names[k]} is {self.excess(q)[k]:.2f} rad from all that was commanded in the last "
            f"{self.lag_ns / NS_PER_MS:.0f} ms, its longest lag: it is at {q[k]:.3f} rad where {commanded}"
        )

    def judge(self, q: Array, now_ns: int) -> RobotFault | None:
        """The fault NOT_FOLLOWING once a measured joint was too far outside for too long."""
        if self.excess(q).max() <= TOLERANCE_RAD:
            self._apart_ns = None
            return None
        self._apart_ns = now_ns if self._apart_ns is None else self._apart_ns
        if now_ns - self._apart_ns < PATIENCE_NS:
            return None
        return RobotFault(FaultCode.NOT_FOLLOWING, f"{self.outside(q)}; find out what holds the arm")

    def _hull(self) -> tuple[Array, Array]:
        written = np.array([each for _, each in self._written])
        return written.min(axis=0), written.max(axis=0)
