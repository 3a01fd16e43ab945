"""The stop of an arm that takes positions: what leads it to rest, and the posture that it holds then; pure."""

from collections.abc import Sequence

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import DriverError
from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.stopping import stop_time, stopping

PAUSE_NS = 50 * NS_PER_MS
HANGS_RAD = 0.05  # at most, at rest, from where it was sent: by its load, and what its stop rounds
RESTS_RAD_S, NEGLIGIBLE_RAD = 1e-3, 1e-3


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


class HeldPosture:
    """Of one arm with so many `joints`, which is where it was sent after `lag_s` at most.

    With `brakes` it stops by its own means: how far a joint goes on then, and where it holds, nobody knows exactly.
    """

    def __init__(self, joints: int, lag_s: float, *, brakes: bool) -> None:
        self._lag_s, self._brakes = lag_s, brakes
        self._moved_ns = np.full(joints, -np.inf)  # when each joint was sent on last
        self._braked = np.zeros(joints, dtype=bool)
        self._way = np.zeros(joints)  # rad, at most, from where it was sent to where it rests

    def sent(self, motion: JointMotion, now_ns: int) -> None:
        """The arm was sent on."""
        self._moved_ns[np.abs(motion.dq) > RESTS_RAD_S] = now_ns

    def stopped(self, motion: JointMotion, limits: JointLimits, now_ns: int) -> None:
        """A stop begins, and `motion` was sent last."""
        if not self._brakes:
            return
        rest = stopping(motion, limits, stop_time(motion, limits))
        self._way = np.abs(rest.q - motion.q) + np.abs(motion.dq) * self._lag_s
        self._braked = (now_ns - self._moved_ns <= self._lag_s * NS_PER_S) | (self._way > NEGLIGIBLE_RAD)

    def hang(self, names: Sequence[str], sent: Array, q: Array) -> Array:
        """Compute how far (n,) the arm, `sent` (n,) somewhere, holds from where it is read, `q` (n,); all in rad.

        A joint that its own stop has braked is led on from where it is read. DriverError where it cannot be there.
        """
        beyond = np.abs(q - sent) - self._way
        if not beyond.max() <= HANGS_RAD:
            k = int(beyond.argmax())
            raise DriverError(
                f"{names[k]} is read at {q[k]:.3f} rad, and was sent to {sent[k]:.3f} rad last: check its "
                "sensor; where the arm was moved by hand, start the remote site again"
            )
        return np.where(self._braked, 0.0, sent - q)
