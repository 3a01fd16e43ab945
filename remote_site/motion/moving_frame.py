"""The frame that moves with a joint's target, and the joint's motion and limits as seen from there; pure."""

import math
from typing import NamedTuple

from remote_site.kinematics.limits import TARGET_SPEED

FRAME_ACCELERATION = 0.8  # of a joint's acceleration, for the frame: the joint must be able to catch it
BRAKING = 0.6  # of a joint's acceleration, to stop with: the rest is for the jerk, and for targets that stop harder

Axis = tuple[float, float, float]  # position in rad, velocity in rad/s, acceleration in rad/s² of one joint


class AxisLimits(NamedTuple):
    """The greatest velocity (rad/s), acceleration (rad/s²) and jerk (rad/s³) of one joint.

    `ending_s` is the longest time for which an acceleration goes on once it is to end: the tick, then by the jerk.
    """

    velocity: float
    acceleration: float
    jerk: float
    ending_s: float


class MovingFrame(NamedTuple):
    """The motion of a joint's target in a tick, and the joint's own highest and lowest velocity, rad and s."""

    position: float
    velocity: float
    acceleration: float
    highest: float
    lowest: float


def frame_of(target: Axis, joint: Axis, limits: AxisLimits) -> MovingFrame:
    """The frame's motion in a tick: the target's, but slow and gentle enough for the joint to catch it, and to stop.

    Of the velocity that target and joint have left before the limit, it gains half at most until its acceleration has
    ended.
    """
    (position, velocity, acceleration), (at, speed, change) = target, joint
    fastest, hardest, jerk, ending_s = limits
    highest = min(fastest, _stoppable(position - at, velocity, hardest))
    lowest = -min(fastest, _stoppable(at - position, -velocity, hardest))
    upper, lower = min(TARGET_SPEED * fastest, highest), max(-TARGET_SPEED * fastest, lowest)
    if not lower <= velocity <= upper:
        return MovingFrame(position, min(max(velocity, lower), upper), 0.0, highest, lowest)
    reached = speed + change * abs(change) / (2 * jerk)
    left = fastest - (max(velocity, reached) if acceleration > 0.0 else max(-velocity, -reached))
    most = max(min(FRAME_ACCELERATION * hardest, left / (2 * ending_s)), 0.0)
    return MovingFrame(position, velocity, min(max(acceleration, -most), most), highest, lowest)


def seen_from(frame: MovingFrame, joint: Axis, limits: AxisLimits, slowest: float) -> tuple[float, ...]:
    """The joint's motion in the frame, then its limits there: highest and lowest velocity, then acceleration.

    What the frame gains until its acceleration has ended counts as velocity already. A joint may always move with
    `slowest` rad/s there, as far as its target leaves it as much.
    """
    position, velocity, acceleration, upper, lower = frame
    at, speed, change = joint
    fastest, hardest, _, ending_s = limits
    slowest = min(slowest, (1.0 - TARGET_SPEED) * fastest)
    gained = acceleration * ending_s
    highest = max(upper - velocity - max(gained, 0.0), slowest)
    lowest = min(lower - velocity - min(gained, 0.0), -slowest)
    own = at - position, speed - velocity, change - acceleration
    return *own, highest, lowest, hardest - acceleration, -hardest - acceleration


def _stoppable(ahead: float, velocity: float, acceleration: float) -> float:
    """The greatest velocity from which a joint can stop where a target `ahead` could that moves away with `velocity`.

    A hand stops when it likes. A joint that catches up with a moving target in the shortest time would be faster than
    the target when it gets there, and swing far beyond one that stops. Infinite for a target that does not move away.
    """
    if velocity <= 0.0:
        return math.inf
    return math.sqrt(2 * BRAKING * acceleration * max(ahead, 0.0) + velocity * velocity)
