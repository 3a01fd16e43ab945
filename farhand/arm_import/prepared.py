"""The arm as it is written: only its joints move, every shape is a simple one, every moving link has a mass."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from farhand.arm_import.choices.cell import ACCELERATION_RAD_S2
from farhand.arm_import.choices.tool import Tool, choose_tool, with_mount
from farhand.arm_import.description.arm import ChosenArm, Locked, fixed_to
from farhand.arm_import.description.elements import Joint, UrdfLink, UrdfMesh, UrdfRobot
from farhand.arm_import.shapes.links import CoveredLink, FindFile, cover_link, with_hulls
from farhand.terminal import ShowProgress
from remote_site.kinematics.model import ASSUMED, GIVEN

TURNS_RAD = math.tau  # to each side, of a joint that turns without end
JERK_RAD_S3 = 500.0  # of a joint whose file states none: an xArm's, as its maker states it; a Panda's is 3750 and more
EFFORT = 50.0  # N m, of a joint whose file states none


@dataclass(frozen=True, slots=True, eq=False)
class PreparedArm:
    """A robot that can be written, its arm and tool, and what differs from the file by kind."""

    robot: UrdfRobot
    arm: ChosenArm
    tool: Tool
    notes: tuple[str, ...]
    dropped: tuple[str, ...]  # visuals
    estimated: tuple[str, ...]  # links: mass and inertia

    @property
    def joints(self) -> tuple[Joint, ...]:
        """The arm's, as they are written."""
        moving = {joint.name for joint in self.arm.joints}
        return tuple(joint for joint in self.robot.joints if joint.name in moving)

    def has_meshes(self, link: str) -> bool:
        """Return whether a link of the file has collision meshes."""
        return any(isinstance(shape.geometry, UrdfMesh) for shape in self.arm.description.links[link].collisions)

    @property
    def locked(self) -> tuple[Locked, ...]:
        """The joints that do not move."""
        return self.arm.locked


def cover_links(arm: ChosenArm, find: FindFile, show: ShowProgress) -> dict[str, CoveredLink]:
    """Every link's meshes read and covered; ModelError where a collision mesh is missing."""
    moved, links = {joint.child for joint in arm.joints}, arm.description.links
    covered = {}
    for name, link in links.items():
        covered[name] = cover_link(link, find, moves=name in moved)
        show("links covered", len(covered), len(links))
    return covered


def prepare(
    arm: ChosenArm,
    covered: Mapping[str, CoveredLink],
    find: FindFile,
    hulls: Collection[str],
    *,
    turned: bool = False,
    jerk: float | None = None,
) -> PreparedArm:
    """Place the tool, and take the convex hulls of some links' meshes instead of the capsules around them.

    The tool's frame is `turned` by half a turn about the tool; `jerk` (rad/s³) is that of joints whose file
    states none.
    """
    tool = choose_tool(arm, covered, turned=turned)
    links = {
        name: (with_hulls(each, arm.description.links[name], find) if name in hulls else each).link
        for name, each in covered.items()
    }
    tool = replace(tool, capsules=tuple(own for own in tool.capsules if own[0] not in hulls))
    joints, notes = _joints(arm, jerk)
    robot = replace(arm.description, links=_without_tool(arm, links, tool, hulls), joints=joints)
    return PreparedArm(
        with_mount(robot, arm.last_link, tool),
        arm,
        tool,
        (*notes, *(note for each in covered.values() for note in each.notes), *tool.notes),
        tuple(dict.fromkeys(drop for each in covered.values() for drop in each.dropped)),
        tuple(name for name, each in covered.items() if each.estimated),
    )


def _without_tool(
    arm: ChosenArm, links: Mapping[str, UrdfLink], tool: Tool, hulls: Collection[str]
) -> dict[str, UrdfLink]:
    """Without the capsules of the tool, which the configuration has, and without the look of its fingers.

    The simulated gripper has fingers of its own.
    """
    written = dict(links)
    locked = {lock.joint for lock in arm.locked}
    for name in fixed_to(arm.description, arm.last_link):
        if name == arm.last_link:
            continue
        finger = tool.own and any(joint.name in locked for joint in arm.description.way_to(name))
        collisions = links[name].collisions if name in hulls else ()
        written[name] = replace(links[name], collisions=collisions, visuals=() if finger else links[name].visuals)
    return written


def _joints(arm: ChosenArm, jerk: float | None) -> tuple[tuple[Joint, ...], list[str]]:
    moving = {joint.name for joint in arm.joints}
    joints, notes = [], []
    for joint in arm.description.joints:
        if joint.name not in moving:
            joints.append(joint)
            continue
        limit = joint.limit
        marks: dict[str, float] = {}
        if joint.kind == "continuous":
            notes.append(f"{joint.name}: turns without end; it got limits of a turn to each side")
            limit = replace(limit, lower=-TURNS_RAD, upper=TURNS_RAD)
            marks |= {f"{ASSUMED}lower": -TURNS_RAD, f"{ASSUMED}upper": TURNS_RAD}
        if not (limit.effort or 0.0) > 0.0:
            notes.append(f"{joint.name}: the file states no effort; {EFFORT:g} N m counts in simulations")
            limit = replace(limit, effort=EFFORT)
            marks[f"{ASSUMED}effort"] = EFFORT
        if not limit.acceleration:
            marks[f"{ASSUMED}acceleration"] = ACCELERATION_RAD_S2
        if limit.jerk is None:
            limit = replace(limit, jerk=jerk or JERK_RAD_S3)
            marks[f"{GIVEN if jerk else ASSUMED}jerk"] = jerk or JERK_RAD_S3
        if joint.mimic is not None:
            notes.append(f"{joint.name}: moves by itself here, though the file lets it follow {joint.mimic.joint}")
        joints.append(
            replace(joint, kind="prismatic" if joint.kind == "prismatic" else "revolute", limit=limit, marks=marks)
        )
    return tuple(joints), notes
