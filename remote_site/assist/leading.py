"""Leads the tool to a pose: beside it first, then straight to it, at a bounded speed; pure."""

import math

from common.geometry import Array, angle_between, rotation_from_vector, transform, vector_from_rotation

SPEED_M_S, SPEED_RAD_S = 0.026, math.radians(8.7)  # of the target; predictions overshoot by up to an eighth
RAMP_S = 0.4  # until the full speed: a target that starts at once is first led beyond
SETTLING_S = 0.2  # the rest of the way shrinks no faster than in proportion to this time
ALIGNED_M, ALIGNED_RAD = 0.003, math.radians(3.0)  # from there on it begins to move along the approach


def step_towards(base_T_here: Array, base_T_there: Array, approach: Array, elapsed_s: float, led_s: float) -> Array:
    """The pose (4 x 4) some time later, `led_s` after the start.

    Along the unit vector `approach` (3,) of the base's frame the tool moves only once it is nearly aligned: so fingers
    come to both sides of what they grasp, and what is placed comes down where it belongs.
    """
    way = base_T_there[:3, 3] - base_T_here[:3, 3]
    ahead = float(approach @ way) * approach
    aside = way - ahead
    aside_m, ahead_m = math.hypot(*aside), math.hypot(*ahead)
    angle_rad = angle_between(base_T_here[:3, :3], base_T_there[:3, :3])
    aligned = max(1.0 - max(aside_m / ALIGNED_M, angle_rad / ALIGNED_RAD), 0.0)
    time_s = elapsed_s * min(led_s / RAMP_S, 1.0)
    aligning = _fraction(time_s, max(aside_m / SPEED_M_S, angle_rad / SPEED_RAD_S))
    position = base_T_here[:3, 3] + aligning * aside + aligned * _fraction(time_s, ahead_m / SPEED_M_S) * ahead
    turn = vector_from_rotation(base_T_there[:3, :3] @ base_T_here[:3, :3].T)
    return transform(rotation_from_vector(aligning * turn) @ base_T_here[:3, :3], position)


def _fraction(time_s: float, needs_s: float) -> float:
    """Compute the fraction of a way that is covered in a time, where all of it needs at least `needs_s`."""
    return min(time_s / max(SETTLING_S, needs_s), 1.0)


def left_over(base_T_here: Array, base_T_there: Array) -> tuple[float, float]:
    """The distance in m and the angle in rad from one pose to another."""
    distance_m = math.dist(base_T_here[:3, 3].tolist(), base_T_there[:3, 3].tolist())
    return distance_m, angle_between(base_T_here[:3, :3], base_T_there[:3, :3])
