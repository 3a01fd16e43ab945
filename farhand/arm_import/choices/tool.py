"""The frame that carries the tool, its z along the tool, and the tool centre point beyond it; pure."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from common.geometry import Array, transform
from farhand.arm_import.description.arm import ChosenArm, fixed_to
from farhand.arm_import.description.elements import Description, Joint, Link
from farhand.arm_import.shapes.capsule import Capsule
from farhand.arm_import.shapes.capsules_of import capsule_of, capsules_of

FRAME = "farhand_tool"
GRIPPER_M = 0.1341  # from the frame that carries the simulated gripper to between the tips of its fingers
ALIGNED = math.cos(math.radians(20))
BEYOND_M = 0.03  # what reaches so far beyond the flange is a tool
TIP_M = 0.01  # a tool grips so far behind its end
SHIFTED_M = 0.005


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """How the tool sits: `last_T_mount` (4 x 4) is the frame that carries it, in the last link's frame.

    The tool centre point is GRIPPER_M beyond, along z. `frame` is an existing one, or FRAME. `capsules` are the
    file's tool by link, where it has its `own`, and the flange is not bare. `notes` say what was turned or moved.
    """

    frame: str
    last_T_mount: Array
    own: bool
    capsules: tuple[tuple[str, Capsule], ...]
    notes: tuple[str, ...]


def choose_tool(arm: ChosenArm, links: Mapping[str, Link], *, turned: bool = False) -> Tool:
    """The tool of an arm whose links have capsules, its frame `turned` by half a turn about the tool's axis."""
    robot, last = arm.description, arm.last_link
    notes: list[str] = []
    last_T_frame = pose_from(robot, last, arm.tool)
    aligned = _aligned(arm, links, last_T_frame, notes)
    carried = [
        (name, capsule)
        for name in fixed_to(robot, last)
        if name != last
        for capsule in capsules_of(links[name].collisions)
    ]
    ends = [_end(capsule, last_T_frame @ aligned, pose_from(robot, last, name)) for name, capsule in carried]
    own = _is_tool(carried)
    shift = max(ends, default=0.0) - TIP_M if own else _face(arm, links, last_T_frame @ aligned)
    shift = shift if shift > (BEYOND_M if own else SHIFTED_M) else 0.0
    if shift:
        what, where = ("the tool centre point", "the tool's") if own else ("the flange", "the last link's")
        notes.append(f"{arm.tool}: {what} is taken {1e3 * shift:.0f} mm beyond it, at {where} end")
    mount = last_T_frame @ aligned @ transform(np.eye(3), np.array([0.0, 0.0, shift - (GRIPPER_M if own else 0.0)]))
    if turned:
        mount = mount @ np.diag([-1.0, -1.0, 1.0, 1.0])
        notes.append(
            f"{FRAME}: turned by half a turn about the tool, so that the last joint begins far from its limits"
        )
    same = np.abs(mount - last_T_frame).max() < 1e-9
    return Tool(arm.tool if same else FRAME, mount, own, tuple(carried) if own else (), tuple(notes))


def with_mount(robot: Description, last_link: str, tool: Tool) -> Description:
    """The robot with the frame that carries the tool."""
    if tool.frame != FRAME:
        return robot
    joint = Joint(f"{FRAME}_joint", "fixed", last_link, FRAME, tool.last_T_mount, np.eye(3)[2])
    return Description(robot.name, robot.root, robot.links | {FRAME: Link(FRAME)}, (*robot.joints, joint))


def pose_from(robot: Description, link: str, frame: str) -> Array:
    """The pose (4 x 4) of a frame in the frame of a link that carries it, all joints between them at zero."""
    pose: Array = np.eye(4)
    while frame != link:
        joint = robot.above(frame)
        if joint is None:
            raise KeyError(f"{link} does not carry {frame}")
        pose, frame = joint.parent_T_joint @ pose, joint.parent
    return pose


def _is_tool(carried: list[tuple[str, Capsule]]) -> bool:
    """Whether something that the file fixes to the last link is larger than a mark at the flange."""
    sizes = [float(np.linalg.norm(capsule.end - capsule.start)) + 2 * capsule.radius for _, capsule in carried]
    return max(sizes, default=0.0) > BEYOND_M


def _end(capsule: Capsule, last_T_frame: Array, last_T_link: Array) -> float:
    """How far a capsule reaches beyond a frame along its z, m."""
    ends = np.array([capsule.start, capsule.end]) @ last_T_link[:3, :3].T + last_T_link[:3, 3]
    return float(((ends - last_T_frame[:3, 3]) @ last_T_frame[:3, 2]).max()) + capsule.radius


def _face(arm: ChosenArm, links: Mapping[str, Link], last_T_frame: Array) -> float:
    """How far the last link reaches beyond the frame where the frame is the link's own, m."""
    if arm.tool != arm.last_link:
        return 0.0
    shapes = links[arm.last_link].collisions
    return max((_end(capsule_of(shape), last_T_frame, np.eye(4)) for shape in shapes), default=0.0)


def _aligned(arm: ChosenArm, links: Mapping[str, Link], last_T_frame: Array, notes: list[str]) -> Array:
    """The turn (4 x 4) after which the frame's z points out of the arm, by the axis that points there."""
    outward = _outward(arm, links, last_T_frame)
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


def _outward(arm: ChosenArm, links: Mapping[str, Link], last_T_frame: Array) -> Array:
    """The last joint's axis (3,) in the last link's frame, to the side on which the arm's end is."""
    joint = arm.joints[-1]
    shapes = [capsule_of(shape) for shape in links[arm.last_link].collisions]
    middle = np.mean([(c.start + c.end) / 2 for c in shapes], axis=0) if shapes else np.zeros(3)
    before = joint.parent_T_joint[:3, :3].T @ joint.parent_T_joint[:3, 3]
    for away in (last_T_frame[:3, 3], before, middle):
        if abs(float(away @ joint.axis)) > SHIFTED_M:
            return joint.axis * math.copysign(1.0, float(away @ joint.axis))
    return joint.axis
