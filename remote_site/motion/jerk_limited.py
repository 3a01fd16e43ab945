"""Jerk-limited motion of the joints that track a target; pure."""

from collections.abc import Iterable

import numpy as np
from ruckig import InputParameter, OutputParameter, Result, Ruckig, RuckigError, Synchronization

from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.motion.moving_frame import Axis, AxisLimits, MovingFrame, frame_of, seen_from
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.stopping import stopping

PLANNED = (Result.Working, Result.Finished)
SLOWEST, ROOM = 1e-3, 1e-2  # rad/s: a joint may always move so fast in the frame; where Ruckig finds no motion, so fast


class JerkLimitedTracker:
    """Follows a moving joint target as quickly as velocity, acceleration and jerk allow, one tick of `dt` s at a time.

    Time-optimal motion to rest is planned (by Ruckig) in the frame that moves and accelerates with the target: there
    the target is at rest, so the joints neither start backwards nor overshoot, and follow a steady target without lag.
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        n = len(limits.names)
        self.limits = limits
        columns = limits.velocity, limits.acceleration, limits.jerk, dt + limits.acceleration / limits.jerk
        self._axes = [AxisLimits(*axis) for axis in zip(*(column.tolist() for column in columns), strict=True)]
        self._slowed, self._speed_scale = self._axes, 1.0
        self._dt = dt
        self._ruckig = Ruckig(n, dt)
        self._input = InputParameter(n)
        self._output = OutputParameter(n)
        self._input.synchronization = Synchronization.No
        self._input.max_jerk = limits.jerk.tolist()
        self._input.target_position = self._input.target_velocity = self._input.target_acceleration = [0.0] * n
        self.motion = JointMotion.at_rest(np.zeros(n))

    def reset(self, motion: JointMotion) -> None:
        """Continue from what was really sent."""
        self.motion = motion

    def track(self, target: JointMotion, speed_scale: float = 1.0) -> JointMotion | Reason:
        """The motion one tick on, towards a moving target; a Reason if none can be planned."""
        planned = self._output
        frame = self._plan_from(self.motion, target, speed_scale, SLOWEST)
        if self._failure() is not None:
            frame = self._plan_from(self.motion, target, speed_scale, ROOM)
            if (failure := self._failure()) is not None:
                return reason(Code.NO_TRAJECTORY, reason=failure)
        dt, q, dq, ddq = self._dt, [], [], []
        seen = planned.new_position, planned.new_velocity, planned.new_acceleration
        for (position, velocity, acceleration, *_), off, speed, change in zip(frame, *seen, strict=True):
            q.append(off + position + (velocity + acceleration * dt / 2) * dt)
            dq.append(speed + velocity + acceleration * dt)
            ddq.append(change + acceleration)
        self.motion = JointMotion(np.array(q), np.array(dq), np.array(ddq))
        return self.motion

    def _failure(self) -> str | None:
        """Let Ruckig plan what it was given; why it found no motion."""
        try:
            self._ruckig.reset()
            result = self._ruckig.update(self._input, self._output)
        except (RuckigError, ValueError) as error:  # ValueError: Ruckig's results have one that its Python enum lacks
            return str(error)
        return None if result in PLANNED else result.name

    def _plan_from(
        self, motion: JointMotion, target: JointMotion, speed_scale: float, slowest: float
    ) -> list[MovingFrame]:
        """Give Ruckig a motion as seen from the target; each joint's frame."""
        if speed_scale != self._speed_scale:
            self._slowed = [limits._replace(velocity=speed_scale * limits.velocity) for limits in self._axes]
            self._speed_scale = speed_scale
        frames, seen = [], []
        for limits, goal, joint in zip(self._slowed, _axes(target), _axes(motion), strict=True):
            frames.append(frame_of(goal, joint, limits))
            seen.append(seen_from(frames[-1], joint, limits, slowest))
        given, columns = self._input, list(zip(*seen, strict=True))
        given.current_position, given.current_velocity, given.current_acceleration = columns[:3]
        given.max_velocity, given.min_velocity, given.max_acceleration, given.min_acceleration = columns[3:]
        return frames

    def stop(self) -> JointMotion:
        """The motion one tick into the jerk-limited stop; at rest, the same posture."""
        self.motion = stopping(self.motion, self.limits, self._dt)
        return self.motion


def _axes(motion: JointMotion) -> Iterable[Axis]:
    return zip(motion.q.tolist(), motion.dq.tolist(), motion.ddq.tolist(), strict=True)
