"""The cell that an import assumes, and what a simulation needs to know of the joints; pure."""

import math
from dataclasses import dataclass

import numpy as np

from common.errors import ModelError
from common.geometry import Array
from farhand.arm_import.description.elements import Joint
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.collision_avoidance import SPARE
from remote_site.safety.config import CollisionConfig, FixtureConfig
from remote_site.safety.stop_bound import longest_stops

TO_SPARE_M, LEAST_MARGIN_M = 0.002, 0.002
TABLE_BEHIND_M, TABLE_THICK_M = 0.35, 0.5
ACCELERATION_RAD_S2 = 7.0  # of a joint whose file states none: less than the 7.5 of a Panda's slowest joint
MOST_ACCELERATION_RAD_S2 = 25.0  # that a configuration may give
LONGEST_STOP_S = 0.55  # with some room to safety.longest_stop_ms
ARMATURE_BY_EFFORT = 0.0025  # kg m² per N m: motor and gear felt at the joint, as of arms whose makers publish both
FRICTION_BY_EFFORT = 0.01
ARMATURES, FRICTIONS = (0.01, 1.0), (0.05, 3.0)
ROBOTS_OWN = 1.25  # of the guard's limits: what the simulated controller allows itself


def table(reach_m: float) -> FixtureConfig:
    """A table under and around the base, its top at z = 0 of the base frame."""
    reach = _round(reach_m)
    return FixtureConfig(name="table", min_m=(-TABLE_BEHIND_M, -reach, -TABLE_THICK_M), max_m=(reach, reach, 0.0))


def margins(near_m: float) -> tuple[float, float]:
    """Return the least distance and the one from which the arm slows, m, for an arm built with gaps of `near_m`.

    Without such gaps these are the defaults. A gap within them would slow the arm wherever it is.
    """
    usual = CollisionConfig()
    if near_m >= usual.slow_m:
        return usual.margin_m, usual.slow_m
    margin = min(usual.margin_m, max(near_m - SPARE - TO_SPARE_M, LEAST_MARGIN_M))
    return round(margin, 4), round(max(near_m - TO_SPARE_M / 2, margin + SPARE), 4)


@dataclass(frozen=True, slots=True)
class JointNumbers:
    """Of each joint: acceleration (rad/s²), armature (kg m²), dry (N m) and viscous friction (N m s/rad)."""

    acceleration: tuple[float, ...]
    armature: tuple[float, ...]
    coulomb: tuple[float, ...]
    viscous: tuple[float, ...]


def joint_numbers(joints: tuple[Joint, ...]) -> JointNumbers:
    """Choose the numbers that a simulation needs: as the file states them, else by the efforts that it states."""
    efforts = [joint.limit.effort or 1.0 for joint in joints]
    friction = [float(np.clip(FRICTION_BY_EFFORT * effort, *FRICTIONS)) for effort in efforts]
    return JointNumbers(
        tuple(_acceleration(joint) for joint in joints),
        tuple(round(float(np.clip(ARMATURE_BY_EFFORT * effort, *ARMATURES)), 3) for effort in efforts),
        tuple(round(joint.friction or usual, 3) for joint, usual in zip(joints, friction, strict=True)),
        tuple(round(joint.damping or usual, 3) for joint, usual in zip(joints, friction, strict=True)),
    )


def _acceleration(joint: Joint) -> float:
    own = joint.limit.acceleration
    return min(own, MOST_ACCELERATION_RAD_S2) if own else ACCELERATION_RAD_S2


def fitting_speed(limits: JointLimits) -> float:
    """The fraction of its own speed from which every joint stops in time; ModelError where none is small enough."""
    for percent in range(100, 0, -1):
        stops = longest_stops(limits.scaled_speed(percent / 100))
        if max(stops) <= LONGEST_STOP_S:
            return percent / 100
    k = stops.index(max(stops))
    raise ModelError(
        f"{limits.names[k]} would take {1e3 * stops[k]:.0f} ms to stop from a hundredth of its speed, with "
        f"{limits.acceleration[k]:g} rad/s² and {limits.jerk[k]:g} rad/s³; {1e3 * LONGEST_STOP_S:.0f} ms are allowed: "
        "give the jerk as the maker states it, 500 rad/s³ and more for most arms, by --jerk where the URDF states none"
    )


@dataclass(frozen=True, slots=True)
class CellView:
    """A simulated camera, and where it looks, in the base's frame or the tool's."""

    name: str
    frame: str
    position_m: tuple[float, float, float]
    looks_at_m: tuple[float, float, float]
    fovy_deg: int


@dataclass(frozen=True, slots=True)
class CellScene:
    """The scene of the simulated views: table, block before the tool, target, and cameras around them."""

    table_centre_m: tuple[float, float]
    table_size_m: tuple[float, float]
    block_size_m: tuple[float, float, float]
    block_centre_m: tuple[float, float]
    target_corner_m: tuple[float, float]
    views: tuple[CellView, ...]


def scene(tool_m: Array, reach_m: float, scale: float, *, points_down: bool) -> CellScene:
    """Around a tool that begins at `tool_m` (3,), whose arm reaches so far; the hand's motion counts `scale` times.

    The simulated operator lowers the tool by 0.16 m, moves it forward by 0.08 m, and closes the gripper: there the
    block stands. Fingers from above reach a little over its top, so that a hand that is too low presses nothing.
    """
    x, y, z = tool_m.tolist()
    reach = _round(reach_m)
    low = max(z - 0.16 * scale, 0.03)
    height = max(round(low + (0.008 if points_down else 0.04), 3), 0.03)
    ahead, middle = x + 0.08 * scale + (0.0 if points_down else 0.01), (x, y, 0.55 * z)
    back = 0.9 + 0.9 * reach
    return CellScene(
        ((reach - TABLE_BEHIND_M) / 2, 0.0),
        (_round(reach + TABLE_BEHIND_M), 2 * reach),
        (0.05, 0.05, height),
        (_round(ahead), _round(y)),
        (_round(ahead + 0.03), _round(y - 0.2 * scale - 0.03)),
        (
            _view("front_high", (x + back, 0.55 * reach, z + 0.75), middle, 34),
            _view("front_low", (x + back, -0.45 * reach, z + 0.05), middle, 32),
            _view("side", (x - 0.05, y - back - 0.3, z + 0.25), middle, 34),
            CellView("gripper", "tool", (-0.15, 0.0, 0.06), (0.0, 0.0, 0.165), 58),
        ),
    )


def _view(name: str, position: tuple[float, float, float], looks_at: tuple[float, float, float], fovy: int) -> CellView:
    (a, b, c), (d, e, f) = map(_round, position), map(_round, looks_at)
    return CellView(name, "base", (a, b, c), (d, e, f), fovy)


def _round(metres: float) -> float:
    """To centimetres."""
    return math.floor(100 * metres + 0.5) / 100
