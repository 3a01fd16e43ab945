"""Limits of an FR3's joints, and whether what is sent to it each millisecond keeps within them; pure.

Positions, speeds, and how both are tied near the ends are from the maker's URDF of the FR3 (franka_description, which
the robot hands out itself); acceleration and jerk from rate_limiting.h of libfranka 0.21. The robot aborts a motion
that breaks one of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.errors import DriverError
from common.geometry import Array
from remote_site.drivers.driver import DriverSetup, check_joints
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits

JOINTS = 7
TICK_S = 0.001
ACCELERATION_SHARE, JERK_SHARE = 0.6, 0.1  # of the robot's own that a configuration may use
ROUNDING = 1e-3  # of every limit's own unit, as libfranka leaves


@dataclass(frozen=True, slots=True)
class RobotLimits:
    """Positions in rad, speed in rad/s, acceleration in rad/s², jerk in rad/s³, each (7,).

    Near an end a joint may only be as fast as `deceleration` (rad/s²) brakes it, less `offset` (rad/s).
    """

    lower: Array
    upper: Array
    velocity: Array
    deceleration: Array
    offset: Array
    acceleration: Array
    jerk: Array

    def slowest(self, q: Array) -> Array:
        """The least velocity, rad/s, that each joint may have at `q` rad; 0 or negative."""
        room = np.sqrt(2 * self.deceleration * np.maximum(q - self.lower, 0.0))
        least: Array = np.maximum(-self.velocity, np.minimum(self.offset - room, 0.0))
        return least

    def fastest(self, q: Array) -> Array:
        """The greatest velocity, rad/s, that each joint may have at `q` rad; 0 or positive."""
        room = np.sqrt(2 * self.deceleration * np.maximum(self.upper - q, 0.0))
        greatest: Array = np.minimum(self.velocity, np.maximum(room - self.offset, 0.0))
        return greatest


FR3 = RobotLimits(
    lower=np.array([-2.9007, -1.8361, -2.9007, -3.0770, -2.8763, 0.4398, -3.0508]),
    upper=np.array([2.9007, 1.8361, 2.9007, -0.1169, 2.8763, 4.6216, 3.0508]),
    velocity=np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26]),
    deceleration=np.array([6.0, 2.585, 3.5, 4.0, 17.0, 5.5, 17.0]),
    offset=np.array([0.652, 0.25, 0.2005, 0.3542, 0.5738, 0.4885, 0.4592]),
    acceleration=np.full(JOINTS, 10.0),
    jerk=np.full(JOINTS, 5000.0),
)


def check_fr3(setup: DriverSetup) -> None:
    """DriverError where the model has other joints than an FR3, or may do more than one; a line for each limit."""
    check_joints(
        setup, JOINTS, "an FR3", "start with --driver franka, or set robot.model = 'fr3' and what belongs to it"
    )
    if mistakes := too_much(setup.joint_names, setup.limits, FR3):
        raise DriverError("\n".join(mistakes))


def too_much(names: Sequence[str], limits: JointLimits, own: RobotLimits) -> list[str]:
    """List which configured limits leave the robot's own no room for what late setpoints add, a sentence for each."""
    mistakes = []
    for what, unit, key, values, most in (
        ("acceleration", "rad/s²", "acceleration_rad_s2", limits.acceleration, ACCELERATION_SHARE * own.acceleration),
        ("jerk", "rad/s³", "jerk_rad_s3", limits.jerk, JERK_SHARE * own.jerk),
    ):
        worst = int(np.argmax(values / most))
        if values[worst] > most[worst]:
            mistakes.append(
                f"the {what} of {names[worst]} is {values[worst]:g}, and more than {most[worst]:g} {unit} leaves no "
                f"room for setpoints that come late: lower robot.{key}"
            )
    return mistakes


class StepCheck:
    """Differences what is sent, as the robot does, and says which limit the next step would break."""

    def __init__(self, limits: RobotLimits, q: Array) -> None:
        self._limits = limits
        self._span_s = TICK_S
        self.sent = JointMotion.at_rest(q)

    def broken(self, q: Array, ticks: int) -> str:
        """The limit that `q` (7,) rad would break `ticks` milliseconds after the last step, "" for none."""
        motion, own = self._next(q, ticks * TICK_S), self._limits
        jerk = (motion.ddq - self.sent.ddq) / self._between(ticks * TICK_S)
        for what, unit, values, least, most in (
            ("position", "rad", motion.q, own.lower, own.upper),
            ("speed", "rad/s", motion.dq, own.slowest(q), own.fastest(q)),
            ("acceleration", "rad/s²", motion.ddq, -own.acceleration, own.acceleration),
            ("jerk", "rad/s³", jerk, -own.jerk, own.jerk),
        ):
            outside = (values < least - ROUNDING) | (values > most + ROUNDING)
            if outside.any():
                k = int(np.flatnonzero(outside)[0])
                allowed = f"{least[k]:.4g} to {most[k]:.4g} {unit}"
                return f"the {what} of joint {k + 1} would be {values[k]:.4g}, and the robot allows {allowed}"
        return ""

    def note_sent(self, q: Array, ticks: int) -> None:
        """Note that `q` is sent `ticks` milliseconds after the last step."""
        self.sent, self._span_s = self._next(q, ticks * TICK_S), ticks * TICK_S

    def _next(self, q: Array, span_s: float) -> JointMotion:
        dq = (q - self.sent.q) / span_s
        return JointMotion(q, dq, (dq - self.sent.dq) / self._between(span_s))

    def _between(self, span_s: float) -> float:
        """From the middle of the last step to the middle of this one: where both speeds belong, s."""
        return (self._span_s + span_s) / 2
