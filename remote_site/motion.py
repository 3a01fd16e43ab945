"""Jerk-limited motion: the leash that holds the target, the joints that follow it, and their stop."""

import math

import numpy as np
from ruckig import InputParameter, OutputParameter, Result, Ruckig, RuckigError, Synchronization

from common.geometry import Array, angle_between, rotation_from_vector, transform, vector_from_rotation
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits
from remote_site.safety.status import Code, Reason, reason
from remote_site.safety.stopping import stopping

PLANNED = (Result.Working, Result.Finished)


class Follower:
    """Follows a moving joint target as quickly as velocity, acceleration and jerk allow, one tick of `dt` s at a time.

    Time-optimal motion to rest is planned (by Ruckig) in the frame that moves with the target: there the target stands
    still, so the joints neither run up to it backwards nor overshoot it, and follow a steady one without lag.
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        n = len(limits.names)
        self._limits = limits
        self._velocity = limits.velocity.tolist()
        self._dt = dt
        self._ruckig = Ruckig(n, dt)
        self._input = InputParameter(n)
        self._output = OutputParameter(n)
        self._input.synchronization = Synchronization.No
        self._input.max_acceleration = limits.acceleration.tolist()
        self._input.max_jerk = limits.jerk.tolist()
        self._input.target_position = self._input.target_velocity = self._input.target_acceleration = [0.0] * n
        self.motion = JointMotion.at_rest(np.zeros(n))

    def reset(self, motion: JointMotion) -> None:
        """Go on from what was really sent."""
        self.motion = motion

    def track(self, q_target: Array, dq_target: Array, speed_scale: float = 1.0) -> JointMotion | Reason:
        """The motion one tick on, towards a target (n,) rad moving with (n,) rad/s; a Reason if none can be planned."""
        fastest = [velocity * speed_scale for velocity in self._velocity]
        frame = [
            min(max(dq, -TARGET_SPEED * most), TARGET_SPEED * most)
            for dq, most in zip(dq_target.tolist(), fastest, strict=True)
        ]
        target, given, planned = q_target.tolist(), self._input, self._output
        given.current_position = [q - goal for q, goal in zip(self.motion.q.tolist(), target, strict=True)]
        given.current_velocity = [dq - moving for dq, moving in zip(self.motion.dq.tolist(), frame, strict=True)]
        given.current_acceleration = self.motion.ddq.tolist()
        given.max_velocity = [most - moving for most, moving in zip(fastest, frame, strict=True)]
        given.min_velocity = [-most - moving for most, moving in zip(fastest, frame, strict=True)]
        try:
            self._ruckig.reset()
            result = self._ruckig.update(given, planned)
        except RuckigError as error:
            return reason(Code.NO_TRAJECTORY, reason=str(error))
        if result not in PLANNED:
            return reason(Code.NO_TRAJECTORY, reason=result.name)
        moved = zip(planned.new_position, target, frame, strict=True)
        self.motion = JointMotion(
            np.array([q + goal + moving * self._dt for q, goal, moving in moved]),
            np.array([dq + moving for dq, moving in zip(planned.new_velocity, frame, strict=True)]),
            np.array(planned.new_acceleration),
        )
        return self.motion

    def stop(self) -> JointMotion:
        """The motion one tick into the jerk-limited stop; at rest, the same posture."""
        self.motion = stopping(self.motion, self._limits, self._dt)
        return self.motion


def leash(base_T_target: Array, base_T_tool: Array, distance_m: float, angle_rad: float) -> tuple[Array, Reason | None]:
    """The target drawn towards the tool until it is no further than both limits, and why if it was drawn."""
    ahead = base_T_target[:3, 3] - base_T_tool[:3, 3]
    distance = math.hypot(*ahead.tolist())
    angle = angle_between(base_T_target[:3, :3], base_T_tool[:3, :3])
    share = min(1.0, distance_m / max(distance, distance_m), angle_rad / max(angle, angle_rad))
    if share >= 1.0:
        return base_T_target, None
    turn = vector_from_rotation(base_T_tool[:3, :3].T @ base_T_target[:3, :3])
    rotation = base_T_tool[:3, :3] @ rotation_from_vector(share * turn)
    why = reason(Code.SATURATED, distance_mm=distance * 1e3, limit_mm=share * distance * 1e3)
    return transform(rotation, base_T_tool[:3, 3] + share * ahead), why
