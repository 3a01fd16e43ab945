"""Times that an arm's stops take, and ways that the tool goes, at most: from a speed that no joint exceeds; pure."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from remote_site.kinematics.limits import JointLimits
from remote_site.safety.stopping import joint_stop, longest_stop


class StopFigures(NamedTuple):
    """Seconds until the last joint rests; the tool's way in m by the joint that moves it furthest, and by all."""

    seconds: float
    by_one_m: float
    by_all_m: float


def steady_stop(limits: JointLimits, levers: Sequence[float], speed: float) -> StopFigures:
    """Every joint stops from `speed` rad/s, or from its own limit, without an acceleration.

    `levers` are how far the tool moves per rad of each joint at most, m.
    """
    seconds, angles = [], []
    for velocity, acceleration, jerk in _bounds(limits, speed):
        stop = joint_stop((0.0, velocity, 0.0), acceleration, jerk)
        seconds.append(stop.duration)
        angles.append(stop.end)
    return _figures(seconds, angles, levers)


def rising_stop(limits: JointLimits, levers: Sequence[float], speed: float) -> StopFigures:
    """The same from the acceleration with which a stop takes longest, and from that with which it leads furthest.

    In both the joint still becomes faster, up to `speed`, while its acceleration is taken back.
    """
    seconds, angles = [], []
    for velocity, acceleration, jerk in _bounds(limits, speed):
        seconds.append(longest_stop(velocity, acceleration, jerk))
        rising = min(acceleration, math.sqrt(2 * jerk * velocity))
        angles.append(joint_stop((0.0, velocity - rising * rising / (2 * jerk), rising), acceleration, jerk).end)
    return _figures(seconds, angles, levers)


def way(limits: JointLimits, levers: Sequence[float], speed: float, seconds: float) -> tuple[float, float]:
    """Compute how far the tool goes at a steady speed, m: by the joint that moves it furthest, and by all at once."""
    ways = [velocity * seconds * lever for (velocity, _, _), lever in zip(_bounds(limits, speed), levers, strict=True)]
    return max(ways), sum(ways)


def _bounds(limits: JointLimits, speed: float) -> list[tuple[float, float, float]]:
    columns = limits.velocity.tolist(), limits.acceleration.tolist(), limits.jerk.tolist()
    return [(min(speed, velocity), acceleration, jerk) for velocity, acceleration, jerk in zip(*columns, strict=True)]


def _figures(seconds: Sequence[float], angles: Sequence[float], levers: Sequence[float]) -> StopFigures:
    ways = [angle * lever for angle, lever in zip(angles, levers, strict=True)]
    return StopFigures(max(seconds), max(ways), sum(ways))
