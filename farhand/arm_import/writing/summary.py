"""Summary of what an import did, to be read by who asked for it; pure."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from farhand.arm_import.choices.tool import GRIPPER_M
from farhand.arm_import.description.arm import Locked
from farhand.arm_import.design import Design
from remote_site.safety.config import CollisionConfig

LISTED = 3
MM = 1e3
MB = 1e6
TENTH = 0.1


@dataclass(frozen=True, slots=True)
class Written:
    """The files of an import, and of the folder `meshes` how many there are and of how many bytes together."""

    toml: str
    urdf: str
    meshes: str
    count: int
    size: int


def summary(design: Design, source: str, written: Written) -> list[str]:
    """The lines: what was imported, locked, dropped, assumed and computed, and what to do next."""
    toml = written.toml
    meshes = f", {written.meshes} ({written.count} meshes, {written.size / MB:.1f} MB)" if written.count else ""
    return [
        f"imported: {source}",
        f"written: {toml}, {written.urdf}{meshes}; to move them, keep them together in one folder",
        *changes(design),
        "next:",
        f"  farhand doctor --config {toml}",
        f"  farhand loopback --config {toml}",
        "a real arm starts with all of these limits; for its first run, see and take a tenth of them:",
        f"  farhand limits --config {toml} --factor {TENTH:g}",
        f"  farhand remote --config {toml} --driver NAME --set robot.limits_factor={TENTH:g}",
    ]


def changes(design: Design) -> list[str]:
    """List what differs from the file, what is assumed and what was computed, a line for each."""
    prepared = design.prepared
    arm, tool = prepared.arm, prepared.tool
    guessed = "guessed by its name, else --tool FRAME" if arm.guessed else "as given"
    lines = [
        f"joints: {', '.join(joint.name for joint in arm.joints)}",
        f"tool: {arm.tool}, {guessed}",
        *(f"locked: {lock}" for lock in map(_lock, prepared.locked)),
        *(f"note: {note}" for note in prepared.notes),
        *_dropped(prepared.dropped),
    ]
    if prepared.estimated:
        lines.append(f"estimated: mass and inertia of {', '.join(prepared.estimated)}, which the file does not state")
    if design.hulls:
        lines.append(
            f"hulls: {', '.join(design.hulls)} keep the convex hulls of their meshes, since capsules around them would "
            "touch each other; all other meshes are in capsules"
        )
    if design.ignored:
        pairs = ", ".join(f"{one} and {other}" for one, other in design.ignored)
        lines.append(f"not compared: {pairs}, which touch in nearly every posture")
    return lines + _assumed(design) + _computed(design) + ([] if tool.own else _gripper(arm.tool))


def _lock(lock: Locked) -> str:
    return f"{lock.joint} at {lock.position:g} ({lock.why})"


def _dropped(dropped: Sequence[str]) -> list[str]:
    """At most a few of the visuals."""
    listed = [f"dropped: the visual {drop}" for drop in dropped[:LISTED]]
    more = len(dropped) - LISTED
    return [
        *listed,
        *([f"dropped: {more} more visuals like these"] if more > 0 else []),
        *(["shown: the collision meshes of links that have no visual left"] if dropped else []),
    ]


def _assumed(design: Design) -> list[str]:
    joints = design.prepared.joints
    unstated = [joint.name for joint in joints if not joint.limit.acceleration]
    lines = ["assumed: the base stands on a table whose top is z = 0 of the base frame"]
    if unstated:
        lines.append(f"assumed: {max(design.joints.acceleration):g} rad/s² for {_all(unstated, len(joints))}")
    without = design.without_jerk
    if without:
        given = "given" if design.jerk_given else "assumed"
        cure = "" if design.jerk_given else "; as the maker states it: --jerk"
        lines.append(
            f"{given}: {design.jerk:g} rad/s³ for {_all(without, len(joints))}, since the file states no jerk{cure}"
        )
    return lines


def _gripper(frame: str) -> list[str]:
    return [f"assumed: a gripper of {MM * GRIPPER_M:.0f} mm on the bare {frame}"]


def _all(names: Sequence[str], joints: int) -> str:
    return "every joint" if len(names) == joints else ", ".join(names)


def _computed(design: Design) -> list[str]:
    start, box = design.start, design.start.box
    size = (box.high - box.low).tolist()
    scale = f"; the hand's motion counts {start.scale:g} times" if start.scale < 1 else ""
    speed = [f"computed: speed {design.speed:g} of the joints' own, so that stops are short enough"]
    return [
        f"computed: start posture {_angles(np.degrees(start.q).tolist())} deg, the tool pointing {start.points}{scale}",
        f"computed: a box of {size[0]:.2f} x {size[1]:.2f} x {size[2]:.2f} m for the tool, reached all over",
        *_margin(design),
        *(speed if design.speed < 1 else []),
    ]


def _margin(design: Design) -> list[str]:
    (margin, _), near = design.margins, design.start.box.near_m
    if margin >= CollisionConfig().margin_m:
        return []
    return [
        f"computed: {MM * margin:.1f} mm are always kept, less than the usual {MM * CollisionConfig().margin_m:.0f}, "
        f"since links of this arm are {MM * near:.0f} mm from each other wherever it is"
    ]


def _angles(degrees: Iterable[float]) -> str:
    return ", ".join(str(round(angle)) for angle in degrees)  # a whole number: never -0
