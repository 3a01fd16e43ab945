"""The frame that carries the tool, its z along the tool, and the tool centre point beyond it; pure."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array, transform
from farhand.arm_import.description.arm import TOOL_NAMES, ChosenArm, fixed_to
from farhand.arm_import.description.elements import Joint, UrdfLink, UrdfRobot
from farhand.arm_import.shapes.capsule import Capsule
from farhand.arm_import.shapes.capsules_of import capsules_of
from farhand.arm_import.shapes.links import CoveredLink

FRAME = "farhand_tool"
GRIPPER_M = 0.1341  # from the frame that carries the simulated gripper to between the tips of its fingers
ALIGNED = math.cos(math.radians(20))
BEYOND_M = 0.03  # what reaches so far beyond the flange is a tool
TIP_M = 0.01  # a tool grips so far behind its end
SHIFTED_M = 0.005


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """The place of the tool: `last_T_mount` (4 x 4) is the frame that carries it, in the last link's frame.

    The tool centre point is GRIPPER_M beyond, along z. `frame` is an existing one, or FRAME. `capsules` are the
    file's tool by link, where it has its `own`, and the flange is not bare. `notes` say what was turned or moved.
    """

    frame: str
    last_T_mount: Array
    own: bool
    capsules: tuple[tuple[str, Capsule], ...]
    notes: tuple[str, ...]


def choose_tool(arm: ChosenArm, covered: Mapping[str, CoveredLink], *, turned: bool = False) -> Tool:
    """The tool of an arm, its frame `turned` by half a turn about the tool's axis."""
    robot, last = arm.description, arm.last_link
    notes: list[str] = []
    last_T_frame = pose_from(robot, last, arm.tool)
    mount = last_T_frame @ _aligned(arm, covered[last].points, last_T_frame, notes)
    fixed = [name for name in fixed_to(robot, last) if name != last]
    carried = [(name, capsule) for name in fixed for capsule in capsules_of(covered[name].link.collisions)]
    own = _is_tool([covered[name].points for name in fixed])
    shift = (
        max((_end(covered[name].points, mount, pose_from(robot, last, name)) for name in fixed), default=0.0) - TIP_M
    )
    if not own:
        shift = _end(covered[last].points, mount, np.eye(4)) if arm.tool == last else 0.0
    elif re.search(TOOL_NAMES[0], arm.tool, re.IGNORECASE):
        shift = 0.0  # it is named as the tool centre point
    shift = shift if shift > SHIFTED_M else 0.0
    if shift:
        what, where = ("the tool centre point", "the tool's") if own else ("the flange", "the last link's")
        notes.append(f"{arm.tool}: {what} is taken {1e3 * shift:.0f} mm beyond it, at {where} end")
    mount = mount @ transform(np.eye(3), np.array([0.0, 0.0, shift - (GRIPPER_M if own else 0.0)]))
    if turned:
        mount = mount @ np.diag([-1.0, -1.0, 1.0, 1.0])
        notes.append(
            f"{FRAME}: turned by half a turn about the tool, so that the last joint begins far from its limits"
        )
    same = np.abs(mount - last_T_frame).max() < 1e-9
    return Tool(arm.tool if same else FRAME, mount, own, tuple(carried) if own else (), tuple(notes))


def with_mount(robot: UrdfRobot, last_link: str, tool: Tool) -> UrdfRobot:
    """The robot with the frame that carries the tool."""
    if tool.frame != FRAME:
        return robot
    joint = Joint(f"{FRAME}_joint", "fixed", last_link, FRAME, tool.last_T_mount, np.eye(3)[2])
    return UrdfRobot(robot.name, robot.root, robot.links | {FRAME: UrdfLink(FRAME)}, (*robot.joints, joint))


def pose_from(robot: UrdfRobot, link: str, frame: str) -> Array:
    """The pose (4 x 4) of a frame in the frame of a link that carries it, all joints between them at zero."""
    pose: Array = np.eye(4)
    while frame != link:
        joint = robot.above(frame)
        if joint is None:
            raise KeyError(f"{link} does not carry {frame}")
        pose, frame = joint.parent_T_joint @ pose, joint.parent
    return pose


def _is_tool(points: Sequence[Array]) -> bool:
    """Return whether something that the file fixes to the last link is larger than a mark at the flange."""
    return any(len(each) > 0 and float(np.ptp(each, axis=0).max()) > BEYOND_M for each in points)


def _end(points: Array, last_T_frame: Array, last_T_link: Array) -> float:
    """Compute how far points of a link (m x 3) reach beyond a frame along its z, m; -inf without any."""
    placed = points @ last_T_link[:3, :3].T + last_T_link[:3, 3]
    return float(((placed - last_T_frame[:3, 3]) @ last_T_frame[:3, 2]).max(initial=-math.inf))


def _aligned(arm: ChosenArm, last_points: Array, last_T_frame: Array, notes: list[str]) -> Array:
    """The turn (4 x 4) after which the frame's z points out of the arm, by the axis that points there."""
    outward = _outward(arm, last_points, last_T_frame)
    along = outward @ last_T_frame[:3, :3]
    k = int(np.argmax(np.abs(along)))
    if abs(along[k]) < ALIGNED:
        notes.append(f"{arm.tool}: no axis of it points out of the arm; its z counts as the tool's direction")
        return np.eye(4)
    if k == 2 and along[k] > 0:
        return np.eye(4)
    z = np.sign(along[k]) * np.eye(3)[k]
    y = np.eye(3)[1] if k != 1 else np.eye(3)[2]
    name = f"{'-' if along[k] < 0 else ''}{'xyz'[k]}"
    notes.append(f"{arm.tool}: the tool points along its {name}, so the frame {FRAME} was added, its z along the tool")
    return transform(np.column_stack([np.cross(y, z), y, z]), np.zeros(3))


def _outward(arm: ChosenArm, last_points: Array, last_T_frame: Array) -> Array:
    """The last joint's axis (3,) in the last link's frame, to the side on which the arm's end is."""
    joint = arm.joints[-1]
    middle = last_points.mean(axis=0) if len(last_points) else np.zeros(3)
    before = joint.parent_T_joint[:3, :3].T @ joint.parent_T_joint[:3, 3]
    for away in (last_T_frame[:3, 3], before, middle):
        if abs(float(away @ joint.axis)) > SHIFTED_M:
            return joint.axis * math.copysign(1.0, float(away @ joint.axis))
    return joint.axis
