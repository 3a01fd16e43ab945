"""The way from where the tool stands to where a path begins or goes on: slow, straight, smooth; pure."""

import numpy as np
from scipy.spatial.transform import Rotation

from common.errors import ConfigError
from common.geometry import Array, angle_between
from local_site.programmed.tool_trajectory import ToolTrajectory

SPEED_M_S, SPEED_RAD_S = 0.06, np.radians(25.0)
SHORTEST_S, STEP_S = 0.5, 0.02
LONGEST_M = 10.0  # longer than any cell: three minutes, and ten thousand poses
PEAK = 1.875  # greatest speed of a minimum-jerk motion, by its mean


def why_too_far(base_T_tool: Array, base_T_begin: Array) -> str:
    """Say why there is no approach from one pose (4 x 4) to another, with the cure; empty where there is one."""
    way_m = _way_m(base_T_tool, base_T_begin)
    if way_m <= LONGEST_M:
        return ""
    return f"the path goes on {way_m:.0f} m away, an approach has at most {LONGEST_M:g} m: is it a path of this cell?"


def approach(base_T_tool: Array, base_T_begin: Array) -> ToolTrajectory:
    """A minimum-jerk motion from one pose (4 x 4) to another, nowhere faster than 60 mm/s and 25 deg/s.

    ConfigError where that is too far.
    """
    if why := why_too_far(base_T_tool, base_T_begin):
        raise ConfigError(why)
    way = _way_m(base_T_tool, base_T_begin)
    turn = angle_between(base_T_tool[:3, :3], base_T_begin[:3, :3])
    duration_s = max(PEAK * way / SPEED_M_S, PEAK * turn / SPEED_RAD_S, SHORTEST_S)
    t_s = np.linspace(0.0, duration_s, int(duration_s / STEP_S) + 2)
    done = _minimum_jerk(t_s / duration_s)
    positions = base_T_tool[:3, 3] + done[:, None] * (base_T_begin[:3, 3] - base_T_tool[:3, 3])
    begin = Rotation.from_matrix(base_T_tool[:3, :3])
    turned = (Rotation.from_matrix(base_T_begin[:3, :3]) * begin.inv()).as_rotvec()
    orientations = (Rotation.from_rotvec(done[:, None] * turned) * begin).as_quat()
    return ToolTrajectory(t_s, positions, orientations)


def _way_m(base_T_tool: Array, base_T_begin: Array) -> float:
    return float(np.linalg.norm(base_T_begin[:3, 3] - base_T_tool[:3, 3]))


def _minimum_jerk(part: Array) -> Array:
    """The distance covered, 0 to 1, after a part of the time."""
    covered: Array = part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
    return covered
