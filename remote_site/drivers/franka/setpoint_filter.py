"""From setpoints, 250 a second and never quite on time, to a smooth motion each millisecond; pure.

A setpoint that comes half a millisecond late, at speed, would be 200 times the jerk that the robot allows, were it gone
to at once. So between setpoints their motion is continued, and a filter of the third order goes with it: it takes over
speed, acceleration and jerk, so that it does not lag behind, and makes up for what remains gently.
"""

from dataclasses import replace

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from remote_site.drivers.franka.robot_limits import TICK_S
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.stopping import stopping

# A setpoint 1 ms early or late, at 2 rad/s, is made up for with 130 rad/s³ more, of the 5000 that the robot allows.
BANDWIDTH_RAD_S = 40.0
GRACE_TICKS = 3  # as long a setpoint is continued when no other comes, then it is led to rest


class SetpointFilter:
    """Begins at rest at `q` (n,) rad; a setpoint comes every `dt` s, more or less.

    To be read: `motion`, and `seq`, the number of the setpoint that it goes with, None before the first.
    """

    def __init__(self, q: Array, limits: JointLimits, dt: float) -> None:
        self._limits, self._dt = limits, dt
        self._newest, self._written_ns = JointMotion.at_rest(q), 0
        self._jerk = np.zeros(len(q))
        self.motion = self._newest
        self.seq: int | None = None

    def add(self, motion: JointMotion, seq: int, t_ns: int) -> None:
        """Go with a setpoint that was written at `t_ns`."""
        elapsed_s = min(max((t_ns - self._written_ns) / NS_PER_S, self._dt / 2), 2 * self._dt)
        most = self._limits.jerk
        self._jerk = np.clip((motion.ddq - self._newest.ddq) / elapsed_s, -most, most)
        self._newest, self._written_ns, self.seq = motion, t_ns, seq

    def starved_ns(self, now_ns: int) -> int:
        """Return how long no setpoint has come while the last one moves, ns."""
        return 0 if self._newest.resting else max(now_ns - self._written_ns, 0)

    def step(self, now_ns: int) -> None:
        """Go on until a millisecond after `now_ns`, which is a millisecond after the last step."""
        (target, jerk), now, w, T = self._target(now_ns), self.motion, BANDWIDTH_RAD_S, TICK_S
        jerk = jerk + w * (w * (w * (target.q - now.q) + 3 * (target.dq - now.dq)) + 3 * (target.ddq - now.ddq))
        self.motion = _continued(now, jerk, T)

    def _target(self, now_ns: int) -> tuple[JointMotion, Array]:
        """Compute where the last setpoint leads until now, and with which jerk: on for a tick as before, then evenly.

        To rest where no other has come for three ticks.
        """
        age_s, still = self.starved_ns(now_ns) / NS_PER_S, np.zeros(len(self._jerk))
        if age_s == 0.0:
            return self._newest, still
        motion = _continued(self._newest, self._jerk, min(age_s, self._dt))
        if age_s <= self._dt:
            return motion, self._jerk
        motion = _continued(motion, still, min(age_s, GRACE_TICKS * self._dt) - self._dt)
        over_s = age_s - GRACE_TICKS * self._dt
        return (motion if over_s <= 0.0 else stopping(motion, braking_limits(self._limits, motion), over_s)), still


def braking_limits(limits: JointLimits, motion: JointMotion) -> JointLimits:
    """The limits of a stop from a motion that accelerates a little harder than they allow: it does so at first."""
    return replace(limits, acceleration=np.maximum(limits.acceleration, np.abs(motion.ddq)))


def _continued(motion: JointMotion, jerk: Array, t: float) -> JointMotion:
    """`t` s later."""
    q = motion.q + t * (motion.dq + t * (motion.ddq / 2 + t * jerk / 6))
    return JointMotion(q, motion.dq + t * (motion.ddq + t * jerk / 2), motion.ddq + t * jerk)
