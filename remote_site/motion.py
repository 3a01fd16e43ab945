"""Jerk-limited motion: the target's course between samples, the joints that follow it, and their stop."""

import math

import numpy as np
from ruckig import InputParameter, OutputParameter, Result, Ruckig, RuckigError, Synchronization

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from remote_site.config import ControlConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.status import Code, Reason, reason
from remote_site.safety.stopping import stopping

TARGET_SPEED = 0.9  # of a joint's limit: the follower must be quicker than its target to catch it

SHORTEST_S = 0.01  # of the interval between two samples, when it tells a velocity


class Course:
    """The joints' target as it moves between hand samples.

    An alpha-beta estimate makes each sample a straight course in time, carried on for at most `predict_ms` beyond the
    sample. The target glides onto every new course, critically damped and without a jump of position or velocity, and
    follows a steady one without lag.
    """

    def __init__(self, limits: JointLimits, config: ControlConfig) -> None:
        self._limits = limits
        self._config = config
        self._fastest = TARGET_SPEED * limits.velocity
        # Further than this from its limits, a joint can stop from any speed.
        far = (self._fastest**2 / limits.acceleration + self._fastest * limits.acceleration / limits.jerk) / 2
        self._far_up, self._far_down = limits.upper - far, limits.lower + far
        self._predict_ns = round(config.predict_ms * NS_PER_MS)
        self._glide = config.glide_rad_s
        self.reset(0, np.zeros(len(limits.names)))

    def reset(self, t_ns: int, q: Array) -> None:
        """A target that rests at `q` (n,) rad since `t_ns`."""
        zero = np.zeros(len(q))
        self._t_ns, self._q, self._dq = t_ns, q.copy(), zero
        self._since_ns, self._off, self._off_rate = t_ns, zero, zero

    def aim(self, t_ns: int, q: Array, now_ns: int) -> None:
        """A new sample of the target (n,) rad for the time `t_ns`, later than the last, known at `now_ns`."""
        elapsed = (t_ns - self._t_ns) / NS_PER_S
        if elapsed <= 0:
            return
        expected = self._q + self._dq * min(elapsed, self._predict_ns / NS_PER_S)
        error = q - expected
        estimate = expected + self._config.position_gain * error
        velocity = self._dq + self._config.velocity_gain / max(elapsed, SHORTEST_S) * error
        self._turn_to(t_ns, estimate, self._bounded(estimate, velocity), now_ns)

    def at(self, now_ns: int) -> tuple[Array, Array]:
        """The target's position (n,) in rad, inside the limits, and velocity (n,) in rad/s at `now_ns`."""
        if now_ns - self._t_ns > self._predict_ns and self._dq.any():
            end_ns = self._t_ns + self._predict_ns
            self._turn_to(end_ns, self._line(end_ns), np.zeros(len(self._q)), end_ns)
        q, dq = self._glided(now_ns)
        inside = self._inside(q)
        return inside, self._bounded(inside, dq)

    def _turn_to(self, t_ns: int, q: Array, dq: Array, now_ns: int) -> None:
        """Take a new course from `now_ns`; what the target is off it decays."""
        here, rate = self._glided(now_ns)
        self._t_ns, self._q, self._dq = t_ns, q, dq
        self._since_ns, self._off, self._off_rate = now_ns, here - self._line(now_ns), rate - dq

    def _line(self, now_ns: int) -> Array:
        line: Array = self._q + self._dq * ((now_ns - self._t_ns) / NS_PER_S)
        return line

    def _glided(self, now_ns: int) -> tuple[Array, Array]:
        t = max(now_ns - self._since_ns, 0) / NS_PER_S
        decay = math.exp(-self._glide * t)
        push = self._off_rate + self._glide * self._off
        off = decay * (self._off + t * push)
        return self._line(now_ns) + off, self._dq + decay * push - self._glide * off

    def _inside(self, q: Array) -> Array:
        inside: Array = np.minimum(np.maximum(q, self._limits.lower), self._limits.upper)
        return inside

    def _bounded(self, q: Array, dq: Array) -> Array:
        """A velocity (n,) from which the joints can stop inside their limits."""
        up = down = self._fastest
        if ((q > self._far_up) | (q < self._far_down)).any():
            up = np.minimum(up, _stoppable(self._limits.upper - q, self._limits))
            down = np.minimum(down, _stoppable(q - self._limits.lower, self._limits))
        bounded: Array = np.minimum(np.maximum(dq, -down), up)
        return bounded


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


def _stoppable(room: Array, limits: JointLimits) -> Array:
    """The speed (n,) from which a joint without acceleration stops within `room` (n,) rad."""
    room = np.maximum(room, 0.0)
    gentle = np.cbrt(room**2 * limits.jerk)
    ramp = limits.acceleration**2 / (2 * limits.jerk)
    hard = np.sqrt(ramp**2 + 2 * limits.acceleration * room) - ramp
    speed: Array = np.where(gentle <= 2 * ramp, gentle, hard)
    return speed
