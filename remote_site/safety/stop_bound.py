"""The longest stop that the joints' limits allow, which may not be longer than configured; pure."""

import math

from common.errors import ConfigError
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.stopping import longest_stop

MS = 1000.0
STEPS = 100  # of the speeds that are tried for the cure


def longest_stops(limits: JointLimits) -> list[float]:
    """The longest stop of every joint in s, from full speed that it has just reached in full acceleration."""
    bounds = zip(limits.velocity.tolist(), limits.acceleration.tolist(), limits.jerk.tolist(), strict=True)
    return [longest_stop(*bound) for bound in bounds]


def check_stops(limits: JointLimits, speed: float, longest_ms: float) -> None:
    """ConfigError with figures and cure where a joint of an arm at `robot.speed` may take longer to stop than allowed.

    Limits that are tightened make a stop longer: without this bound an arm could be configured that hardly ever stops.
    """
    stops = longest_stops(limits)
    if max(stops) * MS <= longest_ms:
        return
    i = stops.index(max(stops))
    raise ConfigError(
        f"{limits.names[i]} may take {math.ceil(MS * stops[i])} ms to stop, from {limits.velocity[i]:.3g} rad/s with "
        f"{limits.acceleration[i]:g} rad/s² and {limits.jerk[i]:g} rad/s³, and safety.longest_stop_ms allows "
        f"{longest_ms:g}: {_cure(limits, speed, longest_ms)}"
    )


def _cure(limits: JointLimits, speed: float, longest_ms: float) -> str:
    more = "allow more robot.jerk_rad_s3 or robot.acceleration_rad_s2"
    for step in range(STEPS, 0, -1):
        fraction = step / STEPS
        if fraction < speed and MS * max(longest_stops(limits.scaled_speed(fraction / speed))) <= longest_ms:
            return f"{more}, or set robot.speed = {fraction:g} or less"
    return more
