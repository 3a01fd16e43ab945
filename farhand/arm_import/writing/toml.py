"""The configuration of an imported arm as TOML, each value with where it comes from; pure."""

from collections.abc import Iterable, Sequence

import numpy as np

from common.text import escaped, toml_string
from farhand.arm_import.choices.cell import ROBOTS_OWN, CellScene
from farhand.arm_import.choices.tool import GRIPPER_M
from farhand.arm_import.design import Design, tool_capsules
from remote_site.kinematics.config import CapsuleConfig
from remote_site.safety.config import CollisionConfig, FixtureConfig


def toml_text(design: Design, urdf: str, head: Sequence[str]) -> str:
    """The file, which begins with the lines of a comment; `urdf` is the arm's file as seen from it."""
    parts = (
        [f"# {escaped(line)}".rstrip() for line in head],
        _robot(design, urdf),
        _mapping(design),
        _safety(design),
        _simulation(design),
        _scene(design),
    )
    return "\n\n".join("\n".join(lines) for lines in parts if lines) + "\n"


def _robot(design: Design, urdf: str) -> list[str]:
    tool, start = design.prepared.tool, design.start
    centre = escaped(design.prepared.arm.tool)
    offset = (
        f"the tool centre point is the file's {centre}; there the simulated gripper grips"
        if tool.own
        else f"ASSUMED: a gripper of this length on the bare {centre}; measure yours"
    )
    stated = [joint.name for joint in design.prepared.joints if joint.limit.acceleration]
    acceleration = (
        "as the file states it"
        if len(stated) == len(design.prepared.joints)
        else ("ASSUMED where the file states none; the maker's manual may allow more")
    )
    whole = design.speed >= 1.0
    speed = "of every joint's own maximum" if whole else "of every joint's own maximum, so that stops are short enough"
    jerks = design.without_jerk
    whose = "as given to the import" if design.jerk_given else "ASSUMED: correct it there as the maker states it"
    jerk = f"# jerk: {design.jerk:g} rad/s³ in {urdf} for {_names(jerks)}, whose file states none; {whose}"
    return [
        "[robot]",
        f"model = {toml_string(urdf)} # beside this file",
        f"tool_frame = {toml_string(tool.frame)} # carries the tool, its z along the tool",
        f"tool_offset_m = {GRIPPER_M} # {offset}",
        f"start_deg = {_row(np.degrees(start.q).tolist(), 1)} # {_start_comment(design)}",
        f"speed = {design.speed:g} # fraction {speed}",
        f"acceleration_rad_s2 = {_row(design.joints.acceleration, 2)} # {acceleration}",
        *([escaped(jerk)] if jerks else []),
        'kinematics = "general"',
        *_capsules(tool_capsules(design.prepared), own=tool.own),
    ]


def _start_comment(design: Design) -> str:
    quality = design.start.quality
    return (
        f"the tool points {design.start.points}, condition {quality.condition:.1f}, "
        f"{1e3 * quality.distance_m:.0f} mm clear, {np.degrees(quality.room_rad):.0f} deg to the nearest limit"
    )


def _capsules(capsules: Sequence[CapsuleConfig], *, own: bool) -> list[str]:
    if not capsules:
        return ["capsules = [] # the tool's shapes are in the URDF"]
    whose = "the file's tool, link by link" if own else "ASSUMED: the gripper above"
    rows = [
        f"  {{ {link}start_m = {_row(c.start_m, 5)}, end_m = {_row(c.end_m, 5)}, radius_m = {c.radius_m:g} }},"
        for c in capsules
        for link in [f"link = {toml_string(c.link)}, " if c.link else ""]
    ]
    return [f"capsules = [ # {whose}", *rows, "]"]


def _mapping(design: Design) -> list[str]:
    if design.start.scale >= 1.0:
        return []
    return [
        "[mapping]",
        f"scale = {design.start.scale:g} # tool motion per hand motion: all of the hand's does not fit before this arm",
    ]


def _safety(design: Design) -> list[str]:
    box = design.start.box
    lines = [
        "[safety] # the box of the tool centre point in the base frame: reached all over, the tool as at the start",
        f"workspace_min_m = {_row(box.low.tolist(), 3)}",
        f"workspace_max_m = {_row(box.high.tolist(), 3)}",
    ]
    lines += ["", *_collision(design)]
    for fixture in design.fixtures:
        lines += ["", *_fixture(fixture)]
    return lines


def _collision(design: Design) -> list[str]:
    (margin, slow), near = design.margins, design.start.box.near_m
    why = (
        f", since links of this arm are {1e3 * near:.0f} mm from each other wherever it is"
        if near < CollisionConfig().slow_m
        else ""
    )
    lines = [
        "[safety.collision]",
        f"margin_m = {margin:g} # always kept{why}",
        f"slow_m = {slow:g} # nearer, the arm approaches more slowly",
    ]
    if design.ignored:
        pairs = ", ".join(f"[{toml_string(one)}, {toml_string(other)}]" for one, other in design.ignored)
        lines.append(f"ignored_pairs = [{pairs}] # these touch in nearly every posture: so they are built")
    return lines


def _fixture(fixture: FixtureConfig) -> list[str]:
    return [
        "# ASSUMED: the base stands on a table whose top is z = 0 of the base frame. Measure yours, and every wall.",
        "[[safety.collision.fixtures]]",
        f"name = {toml_string(fixture.name)}",
        f"min_m = {_row(fixture.min_m, 3)}",
        f"max_m = {_row(fixture.max_m, 3)}",
    ]


def _simulation(design: Design) -> list[str]:
    numbers = design.joints
    own = [ROBOTS_OWN * value for value in numbers.acceleration]
    return [
        "# ASSUMED, for simulations only: by each joint's effort where the file states no damping or friction.",
        "[simulation.arm]",
        f"armature_kg_m2 = {_row(numbers.armature, 3)}",
        f"coulomb_n_m = {_row(numbers.coulomb, 3)}",
        f"viscous_n_m_s = {_row(numbers.viscous, 3)}",
        "",
        "[simulation.servo] # the simulated robot's own limits, wider than the guard's",
        f"max_velocity_rad_s = {ROBOTS_OWN * float(design.limits.velocity.max()) * design.speed:.2f}",
        f"max_acceleration_rad_s2 = {_row(own, 2)}",
    ]


def _scene(design: Design) -> list[str]:
    scene = design.scene
    lines = [
        "# What the simulated views show: the table, and a block where the simulated operator grasps.",
        "[simulation.scene]",
        "floor_z_m = -0.75",
        "pedestal_side_m = 0.24",
        "table_z_m = 0.0",
        f"table_centre_xy_m = {_row(scene.table_centre_m, 3)}",
        f"table_size_xy_m = {_row(scene.table_size_m, 3)}",
        f"target_corner_xy_m = {_row(scene.target_corner_m, 3)}",
        "",
        "[simulation.block]",
        f"size_m = {_row(scene.block_size_m, 3)}",
        f"centre_xy_m = {_row(scene.block_centre_m, 3)}",
    ]
    return lines + _views(scene)


def _views(scene: CellScene) -> list[str]:
    lines = []
    for view in scene.views:
        lines += [
            "",
            "[[simulation.views]]",
            f"name = {toml_string(view.name)}",
            *(['frame = "tool"'] if view.frame == "tool" else []),
            f"position_m = {_row(view.position_m, 3)}",
            f"looks_at_m = {_row(view.looks_at_m, 3)}",
            f"fovy_deg = {view.fovy_deg}",
        ]
    return lines


def _row(values: Iterable[float], digits: int) -> str:
    return f"[{', '.join(str(round(float(value), digits) + 0.0) for value in values)}]"


def _names(names: Sequence[str]) -> str:
    return "all joints" if len(names) > 4 else ", ".join(names)
