"""The frame that moves with a joint's target, and the joint's motion and limits as seen from there; pure."""

from typing import NamedTuple

from remote_site.kinematics.limits import TARGET_SPEED

FRAME_ACCELERATION = 0.8  # of a joint's acceleration, for the frame: the joint must be able to catch it

Axis = tuple[float, float, float]  # position in rad, velocity in rad/s, acceleration in rad/s² of one joint


class AxisLimits(NamedTuple):
    """The greatest velocity (rad/s), acceleration (rad/s²) and jerk (rad/s³) of one joint.

    `ending_s` is the longest time for which an acceleration goes on once it is to end: the tick, then by the jerk.
    """

    velocity: float
    acceleration: float
    jerk: float
    ending_s: float


def frame_of(target: Axis, joint: Axis, limits: AxisLimits) -> Axis:
    """The frame's motion in a tick: the target's, but slow and gentle enough for the joint to catch it.

    Of the velocity that target and joint have left before the limit, it gains half at most until its acceleration has
    ended.
    """
    (position, velocity, acceleration), (_, speed, change) = target, joint
    fastest, hardest, jerk, ending_s = limits
    bound = TARGET_SPEED * fastest
    if not -bound <= velocity <= bound:
        return position, bound if velocity > 0.0 else -bound, 0.0
    reached = speed + change * abs(change) / (2 * jerk)
    left = fastest - (max(velocity, reached) if acceleration > 0.0 else max(-velocity, -reached))
    most = max(min(FRAME_ACCELERATION * hardest, left / (2 * ending_s)), 0.0)
    return position, velocity, min(max(acceleration, -most), most)


def seen_from(frame: Axis, joint: Axis, limits: AxisLimits) -> tuple[float, ...]:
    """The joint's motion in the frame, then its limits there: highest and lowest velocity, then acceleration.

    What the frame gains until its acceleration has ended counts as velocity already.
    """
    (position, velocity, acceleration), (at, speed, change) = frame, joint
    fastest, hardest, _, ending_s = limits
    gained = acceleration * ending_s
    highest = fastest - velocity - (gained if gained > 0.0 else 0.0)
    lowest = -fastest - velocity - (gained if gained < 0.0 else 0.0)
    own = at - position, speed - velocity, change - acceleration
    return *own, highest, lowest, hardest - acceleration, -hardest - acceleration
