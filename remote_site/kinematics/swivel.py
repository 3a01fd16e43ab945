"""The elbow of a seven-axis arm, which turns about the line from shoulder to wrist as the operator's does."""

import math

import numpy as np
import pinocchio as pin

from common.errors import ConfigError
from common.geometry import Array
from remote_site.kinematics.config import SolverConfig
from remote_site.kinematics.model import ArmModel

LEAST_RADIUS = 0.03  # m: an elbow nearer to the line has no swivel angle
LEAST_TURNING = 0.05  # rad/s of the elbow per rad/s of the joints
SPEED_FRACTION = 0.7  # of the joints' speeds: the tool has priority
ACCELERATION = 8.0  # rad/s² of the elbow
FORWARD = np.array([1.0, 0.0, 0.0])  # of the base: along it the operator's arm reaches too
SEVEN = 7


class Swivel:
    """Turns the robot's elbow about its line from shoulder to wrist by as much as the operator's has turned.

    The operator's shoulder is not seen. Since the wrist lies on the operator's line too, the component of wrist to
    elbow across the direction in which the arm reaches gives the swivel angle: across the base's x, or, for a robot of
    the operator's shape and pose, across its own line. Both angles count from where they were when following began;
    the zero directions are projected along as the lines move.
    """

    def __init__(self, joints: tuple[int, int, int], config: SolverConfig) -> None:
        self._shoulder, self._elbow, self._wrist = joints
        self._gain, self._fastest = config.swivel_gain_s, config.swivel_speed_rad_s
        self._alike = config.swivel_about == "arm"
        self.forget()

    @classmethod
    def of(cls, model: ArmModel, config: SolverConfig) -> "Swivel | None":
        """The swivel of a seven-axis arm, None for others; ConfigError if the configured joints are not the arm's."""
        names = model.joint_names
        chosen = config.swivel_joints
        if chosen is None:
            return cls((2, 4, 6), config) if len(names) == SEVEN else None
        unknown = [name for name in chosen if name not in names]
        if unknown:
            raise ConfigError(f"swivel_joints: no joint {', '.join(unknown)}; the joints are {', '.join(names)}")
        first, second, third = (names.index(name) + 1 for name in chosen)
        if not first < second < third:
            raise ConfigError("swivel_joints: give shoulder, elbow and wrist in the order of the joints")
        return cls((first, second, third), config)

    def forget(self) -> None:
        """Take both swivel angles as zero at the next call."""
        self._zero: Array | None = None
        self._theirs: Array | None = None
        self._speed = 0.0

    def rate(
        self, data: pin.Data, jacobian: Array, free: Array, wrist_to_elbow: Array, fastest: Array, dt: float
    ) -> float:
        """The rate (1/s) along the null-space direction `free` (n,) of the joints, which leaves the tool where it is.

        `data` holds the placements, `jacobian` (6 x n) is the world's; the operator's wrist to elbow (3,) in m is in
        the base's axes; `fastest` (n,) in rad/s bounds the joints. Zero while either elbow has no swivel angle.
        """
        shoulder, elbow = data.oMi[self._shoulder].translation, data.oMi[self._elbow].translation
        axis = data.oMi[self._wrist].translation - shoulder
        axis = axis / math.sqrt(float(axis @ axis))
        line = axis if self._alike else FORWARD
        mine, theirs = _across(axis, elbow - shoulder), _across(line, wrist_to_elbow)
        if mine is None or theirs is None:
            self._speed = 0.0
            return 0.0
        self._zero = _across(axis, self._zero if self._zero is not None else mine)
        self._theirs = _across(line, self._theirs if self._theirs is not None else theirs)
        if self._zero is None or self._theirs is None:
            return 0.0
        behind = math.remainder(_angle(line, self._theirs, theirs) - _angle(axis, self._zero, mine), math.tau)
        wanted = min(max(self._gain * behind, -self._fastest), self._fastest)
        self._speed += min(max(wanted - self._speed, -ACCELERATION * dt), ACCELERATION * dt)
        twist = jacobian[:, : self._elbow - 1] @ free[: self._elbow - 1]
        velocity = twist[:3] + pin.skew(twist[3:]) @ elbow
        turning = float((pin.skew(axis) @ mine) @ velocity) / float(mine @ mine)
        most = SPEED_FRACTION / float((np.abs(free) / fastest).max())
        if abs(turning) < LEAST_TURNING:
            return 0.0
        return min(max(self._speed / turning, -most), most)


def _angle(axis: Array, first: Array, second: Array) -> float:
    """The angle from the first to the second vector about a unit axis, to which both are perpendicular, rad."""
    return math.atan2(float((pin.skew(axis) @ first) @ second), float(first @ second))


def _across(axis: Array, vector: Array) -> Array | None:
    """The part of a vector across the axis; None if it is too short to have a direction."""
    part: Array = vector - axis * float(axis @ vector)
    return part if float(part @ part) > LEAST_RADIUS**2 and np.isfinite(part).all() else None
