"""The stop of an arm that cannot brake by itself: the positions that lead it to rest within its limits; pure."""

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.stopping import stop_time, stopping

PAUSE_NS = 50 * NS_PER_MS


class WrittenStop:
    """The quickest stop from `motion`, which was written at `written_ns`, one position each `period_ns`.

    Each is a period's motion from the one before it, also where this process has paused. `lag_s` is how much later than
    written the arm may be where it was sent.
    """

    def __init__(self, motion: JointMotion, limits: JointLimits, written_ns: int, period_ns: int, lag_s: float) -> None:
        self._motion, self._limits, self._period_ns = motion, limits, period_ns
        self._last_ns = written_ns
        self._into_ns = 0  # the stop, of what was written last
        self._whole_ns = round((stop_time(motion, limits) + lag_s) * NS_PER_S)
        self._longest_ns = 2 * period_ns + PAUSE_NS

    def due(self, now_ns: int) -> Array | None:
        """The positions (n,) in rad to write now, None if it is not their time yet."""
        late_ns = now_ns - self._last_ns - self._period_ns
        if late_ns < 0:
            return None
        self._last_ns = now_ns - late_ns if late_ns < self._period_ns else now_ns
        self._into_ns += self._period_ns
        return stopping(self._motion, self._limits, self._into_ns / NS_PER_S).q

    def ended(self, now_ns: int) -> bool:
        """The arm has come to rest: it was led there, or this process paused and it stands where it was sent last."""
        return self._into_ns >= self._whole_ns or now_ns - self._last_ns > self._longest_ns
