"""Jerk-limited motion: the leash that limits the target's lead, and the joints that track it; pure."""

import math

import numpy as np
from ruckig import InputParameter, OutputParameter, Result, Ruckig, RuckigError, Synchronization

from common.geometry import Array, angle_between, rotation_from_vector, transform, vector_from_rotation
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.stopping import stopping

PLANNED = (Result.Working, Result.Finished)


class JerkLimitedTracker:
    """Follows a moving joint target as quickly as velocity, acceleration and jerk allow, one tick of `dt` s at a time.

    Time-optimal motion to rest is planned (by Ruckig) in the frame that moves with the target: there the target is
    at rest, so the joints neither start backwards nor overshoot, and follow a steady target without lag.
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        n = len(limits.names)
        self.limits = limits
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
        """Continue from what was really sent."""
        self.motion = motion

    def track(self, q_target: Array, dq_target: Array, speed_scale: float = 1.0) -> JointMotion | Reason:
        """The motion one tick on, towards a target (n,) rad moving with (n,) rad/s; a Reason if none can be planned."""
        target, planned = q_target.tolist(), self._output
        frame = self._plan_from(self.motion, target, dq_target.tolist(), speed_scale)
        try:
            self._ruckig.reset()
            result = self._ruckig.update(self._input, planned)
        except RuckigError as error:
            return reason(Code.NO_TRAJECTORY, reason=str(error))
        if result not in PLANNED:
            return reason(Code.NO_TRAJECTORY, reason=result.name)
        dt, q, dq = self._dt, [], []
        for off, goal, speed, moving in zip(planned.new_position, target, planned.new_velocity, frame, strict=True):
            q.append(off + goal + moving * dt)
            dq.append(speed + moving)
        self.motion = JointMotion(np.array(q), np.array(dq), np.array(planned.new_acceleration))
        return self.motion

    def _plan_from(
        self, motion: JointMotion, q_target: list[float], dq_target: list[float], speed_scale: float
    ) -> list[float]:
        """Give Ruckig a motion as seen from the target; the speed (n,) of that frame in rad/s."""
        frame, q_off, dq_off, highest, lowest = [], [], [], [], []
        joints = zip(motion.q.tolist(), q_target, motion.dq.tolist(), dq_target, self._velocity, strict=True)
        for q, goal, dq, wanted, velocity in joints:
            most = velocity * speed_scale
            bound = TARGET_SPEED * most
            moving = bound if wanted > bound else -bound if wanted < -bound else wanted
            frame.append(moving)
            q_off.append(q - goal)
            dq_off.append(dq - moving)
            highest.append(most - moving)
            lowest.append(-most - moving)
        given = self._input
        given.current_position, given.current_velocity = q_off, dq_off
        given.current_acceleration = motion.ddq.tolist()
        given.max_velocity, given.min_velocity = highest, lowest
        return frame

    def stop(self) -> JointMotion:
        """The motion one tick into the jerk-limited stop; at rest, the same posture."""
        self.motion = stopping(self.motion, self.limits, self._dt)
        return self.motion


def leash(base_T_target: Array, base_T_tool: Array, distance_m: float, angle_rad: float) -> tuple[Array, Reason | None]:
    """The target drawn towards the tool until it is no further than both limits, and why if it was drawn."""
    distance = math.dist(base_T_target[:3, 3].tolist(), base_T_tool[:3, 3].tolist())
    angle = angle_between(base_T_target[:3, :3], base_T_tool[:3, :3])
    fraction = min(1.0, distance_m / max(distance, distance_m), angle_rad / max(angle, angle_rad))
    if fraction >= 1.0:
        return base_T_target, None
    ahead = base_T_target[:3, 3] - base_T_tool[:3, 3]
    turn = vector_from_rotation(base_T_tool[:3, :3].T @ base_T_target[:3, :3])
    rotation = base_T_tool[:3, :3] @ rotation_from_vector(fraction * turn)
    why = reason(Code.SATURATED, distance_mm=distance * 1e3, limit_mm=fraction * distance * 1e3)
    return transform(rotation, base_T_tool[:3, 3] + fraction * ahead), why
