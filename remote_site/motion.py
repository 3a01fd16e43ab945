"""Jerk-limited motion: the leash that holds the target, the joints that follow it, and their stop."""

import math

import numpy as np
from ruckig import InputParameter, OutputParameter, Result, Ruckig, RuckigError, Synchronization

from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits
from remote_site.safety.status import Code, Reason, reason
from remote_site.safety.stopping import stopping


class Follower:
    """Follows a moving joint target as quickly as velocity, acceleration and jerk allow, one tick of `dt` s at a time.

    Time-optimal motion to rest is planned (by Ruckig) in the frame that moves with the target: there the target stands
    still, so the joints neither run up to it backwards nor overshoot it, and follow a steady one without lag.
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        n = len(limits.names)
        self._limits = limits
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
        velocity = self._limits.velocity * speed_scale
        frame_dq = np.minimum(np.maximum(dq_target, -TARGET_SPEED * velocity), TARGET_SPEED * velocity)
        given = self._input
        given.current_position = (self.motion.q - q_target).tolist()
        given.current_velocity = (self.motion.dq - frame_dq).tolist()
        given.current_acceleration = self.motion.ddq.tolist()
        given.max_velocity = (velocity - frame_dq).tolist()
        given.min_velocity = (-velocity - frame_dq).tolist()
        try:
            self._ruckig.reset()
            result = self._ruckig.update(given, self._output)
        except RuckigError as error:
            return reason(Code.NO_TRAJECTORY, reason=str(error))
        if result not in (Result.Working, Result.Finished):
            return reason(Code.NO_TRAJECTORY, reason=result.name)
        planned = self._output
        self.motion = JointMotion(
            np.array(planned.new_position) + q_target + frame_dq * self._dt,
            np.array(planned.new_velocity) + frame_dq,
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
    distance = math.sqrt(float(ahead @ ahead))
    tool_R_target = base_T_tool[:3, :3].T @ base_T_target[:3, :3]
    turn = vector_from_rotation(tool_R_target)
    angle = math.sqrt(float(turn @ turn))
    share = min(1.0, distance_m / max(distance, distance_m), angle_rad / max(angle, angle_rad))
    if share >= 1.0:
        return base_T_target, None
    rotation = base_T_tool[:3, :3] @ rotation_from_vector(share * turn)
    why = reason(Code.SATURATED, distance_mm=distance * 1e3, limit_mm=share * distance * 1e3)
    return transform(rotation, base_T_tool[:3, 3] + share * ahead), why
