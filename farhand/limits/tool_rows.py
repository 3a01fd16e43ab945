"""An arm's tool, its payload and the box that it is held in, each with the key that it comes from."""

import math
from itertools import groupby

from remote_site.config import RemoteConfig
from remote_site.kinematics.config import GRIPPER, CapsuleConfig, RobotConfig
from remote_site.safety.config import SafetyConfig

MM = 1000.0
Row = tuple[str, str, str]


def tool_rows(config: RemoteConfig) -> list[Row]:
    """What, its value, and its source."""
    robot = config.robot
    x, y, z = (MM * robot.tool_T_tcp[:3, 3]).tolist()
    payload = "not stated" if robot.payload_kg is None else f"{robot.payload_kg:g}"
    return [
        ("tool's frame", robot.tool_frame, "robot.tool_frame"),
        ("tool centre point in it, mm", f"{x:g}, {y:g}, {z:g}", "robot.tool_offset_m, along z"),
        *_capsule_rows(robot),
        ("largest grip force, N", f"{config.grip.force_n:g}", "grip.force_n; the gripper's own may be less"),
        ("payload beyond the tool, kg", payload, "robot.payload_kg; shown only, no limit follows from it"),
        ("box of the tool centre point, m", _box(config.safety), "safety.workspace_min_m, safety.workspace_max_m"),
    ]


def _capsule_rows(robot: RobotConfig) -> list[Row]:
    """A row for each link that carries capsules."""
    if not robot.capsules:
        return [("capsules around the tool", "none: a bare flange", "robot.capsules")]
    source = "robot.capsules" + (_whose(robot) if robot.capsules == GRIPPER else "")
    carried = [(capsule.link or robot.tool_frame, _reach_m(capsule)) for capsule in robot.capsules]
    rows = []
    for link, group in groupby(sorted(carried), key=lambda item: item[0]):
        reaches_m = [reach_m for _, reach_m in group]
        extent = f"{len(reaches_m)}, up to {MM * max(reaches_m):.0f} mm from its origin"
        rows.append((f"capsules on {link}", extent, source))
    return rows


def _whose(robot: RobotConfig) -> str:
    """Of the gripper that counts where none is given, which is the A465's own alone."""
    default = robot.model == RobotConfig().model
    return ", by default the A465's gripper" if default else ", the shape of the A465's gripper: give your own"


def _reach_m(capsule: CapsuleConfig) -> float:
    """How far a capsule extends from the origin of its link."""
    return max(math.hypot(*end) for end in (capsule.start_m, capsule.end_m)) + capsule.radius_m


def _box(safety: SafetyConfig) -> str:
    sides = zip("xyz", safety.workspace_min_m, safety.workspace_max_m, strict=True)
    return ", ".join(f"{axis} {low:g} to {high:g}" for axis, low, high in sides)
