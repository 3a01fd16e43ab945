"""Which of a robot is the arm: its joints, the frame of its tool, and what is locked; pure."""

import difflib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from common.errors import ConfigError, ModelError
from common.geometry import Array, rotation_from_vector, transform
from farhand.arm_import.description.elements import Joint, UrdfRobot

MOVING = ("revolute", "continuous", "prismatic")
FREE = ("floating", "planar", "spherical")
FINGER = re.compile(r"finger|jaw|knuckle|thumb|claw", re.IGNORECASE)
GRIPPER = re.compile(r"grip", re.IGNORECASE)  # of a joint that opens one; its link may be the hand that a wrist turns
SIX = 6  # joints that hold a tool in any direction
LONG = 3  # moving joints of a branch that is an arm and no finger
TOOL_NAMES = (r"tcp|tool_?cent|grasp", r"tool0$", r"tool|end_?eff|(^|_)ee($|_)|eef", r"flange|hand$")


@dataclass(frozen=True, slots=True)
class Locked:
    """A joint that is not the arm's, where it is locked (rad or m), and why it is not."""

    joint: str
    position: float
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class ChosenArm:
    """A robot with one arm that moves: its `joints` from the base on; all others are fixed.

    `last_link` is the last joint's; `tool` the frame of the tool, `guessed` where nobody named it.
    """

    description: UrdfRobot
    joints: tuple[Joint, ...]
    tool: str
    guessed: bool
    locked: tuple[Locked, ...]

    @property
    def last_link(self) -> str:
        """The link of the last joint."""
        return self.joints[-1].child


def choose_arm(
    whole: UrdfRobot, tool: str | None, base: str | None = None, positions: Mapping[str, float] | None = None
) -> ChosenArm:
    """The arm that carries `tool`, or the only one that there is, on the link `base`, the root without one.

    `positions` says where joints are locked, rad or m. ModelError and ConfigError name what stands against it.
    """
    robot = _rooted(whole, base)
    if tool is not None:
        _check_frame(robot, tool, "--tool")
    way = [j for j in (robot.way_to(tool) if tool else _trunk(robot)) if j.kind != "fixed"]
    while tool and way and _is_finger(way[-1]):
        way.pop()
    _check_way(way)
    chosen = tool or _tool_of(robot, way[-1].child)
    locked = _locked(robot, way, positions or {})
    fixed = _fixed(robot, {lock.joint: lock.position for lock in locked})
    arm = {joint.name for joint in way}
    return ChosenArm(fixed, tuple(j for j in way if j.name in arm), chosen, tool is None, tuple(locked))


def _rooted(whole: UrdfRobot, base: str | None) -> UrdfRobot:
    """Keep only what hangs from `base`."""
    if base is None:
        return whole
    _check_frame(whole, base, "--base")
    kept = set(whole.beyond(base))
    links = {name: link for name, link in whole.links.items() if name in kept}
    return replace(whole, root=base, links=links, joints=tuple(j for j in whole.joints if j.parent in kept))


def _check_frame(robot: UrdfRobot, name: str, option: str) -> None:
    if name not in robot.links:
        near = difflib.get_close_matches(name, robot.links, n=1, cutoff=0.4)
        meant = f"did you mean {near[0]}? The frames are" if near else "the frames are"
        raise ConfigError(f"{option} {name}: there is no such frame; {meant} {', '.join(robot.links)}")


def check_joints(arm: ChosenArm) -> None:
    """ModelError for an arm that cannot hold its tool in any direction."""
    if len(arm.joints) < SIX:
        names = ", ".join(joint.name for joint in arm.joints)
        raise ModelError(
            f"the arm to {arm.tool} has {len(arm.joints)} moving joints ({names}), and to lead a tool like a hand "
            f"takes {SIX} or more; where the file has such an arm, name the frame at its end: --tool FRAME"
        )


def _check_way(way: list[Joint]) -> None:
    """ModelError where the joints to the tool are none of an arm."""
    if not way:
        raise ModelError("no joint moves the tool; give the frame at the arm's end: --tool FRAME")
    free = [joint for joint in way if joint.kind in FREE]
    if free:
        after = free[-1].child
        raise ModelError(
            f"{', '.join(f'{j.name} ({j.kind})' for j in free)}: only revolute and prismatic joints are moved; "
            f"where the arm stands on a base that is fixed in the cell, begin there: --base {after}"
        )
    unlimited = [
        joint.name
        for joint in way
        if joint.kind != "continuous" and (joint.limit.lower is None or joint.limit.upper is None)
    ]
    slow = [joint.name for joint in way if not (joint.limit.velocity or 0.0) > 0.0]
    backward = [
        joint.name
        for joint in way
        if joint.limit.lower is not None and joint.limit.upper is not None and joint.limit.lower >= joint.limit.upper
        if joint.kind != "continuous"
    ]
    if unlimited or slow or backward:
        form = '<limit lower="…" upper="…" velocity="…" effort="…"/>'
        wrong = ", ".join(dict.fromkeys((*unlimited, *backward, *slow)))
        raise ModelError(
            f"{wrong}: a joint of the arm needs {form}, lower below upper and velocity above 0, as its maker states "
            "them; add them to the URDF"
        )


def _is_finger(joint: Joint) -> bool:
    named = FINGER.search(joint.name) or FINGER.search(joint.child) or GRIPPER.search(joint.name)
    return joint.mimic is not None or named is not None


def _next_moving(robot: UrdfRobot, link: str) -> list[Joint]:
    """The first joints beyond a link that move and are no fingers'."""
    found: list[Joint] = []
    for joint in robot.below(link):
        if joint.kind == "fixed":
            found += _next_moving(robot, joint.child)
        elif not _is_finger(joint):
            found.append(joint)
    return found


def _depth(robot: UrdfRobot, joint: Joint) -> int:
    """Count the joints of a chain that follow each other, this one included."""
    return 1 + max((_depth(robot, after) for after in _next_moving(robot, joint.child)), default=0)


def _trunk(robot: UrdfRobot) -> list[Joint]:
    """The moving joints of the only arm; ModelError where there are several, or none."""
    trunk: list[Joint] = []
    link = robot.root
    while ahead := _next_moving(robot, link):
        if len(ahead) > 1:
            ahead = [joint for joint in ahead if _depth(robot, joint) >= LONG]
        if len(ahead) > 1 and len(trunk) >= SIX:
            break  # they are the fingers of a hand
        if len(ahead) > 1:
            ends = [_tool_of(robot, _end_of(robot, joint, len(trunk) + 1)) for joint in ahead]
            raise ModelError(
                f"{len(ahead)} chains begin at {link} ({', '.join(j.name for j in ahead)}); say which is the arm by "
                f"the frame of its tool: {' or '.join(f'--tool {end}' for end in ends)}"
            )
        if not ahead:
            break
        trunk.append(ahead[0])
        link = ahead[0].child
    return trunk


def _end_of(robot: UrdfRobot, joint: Joint, moving: int) -> str:
    """The last link of the longest chain from a joint on, the last of so many; an arm ends where its hand begins."""
    ahead = _next_moving(robot, joint.child)
    if not ahead or (len(ahead) > 1 and moving >= SIX):
        return joint.child
    return _end_of(robot, max(ahead, key=lambda j: _depth(robot, j)), moving + 1)


def fixed_to(robot: UrdfRobot, link: str, stops: Callable[[Joint], bool] = lambda j: j.kind != "fixed") -> list[str]:
    """A link and all that is fixed to it."""
    found = [link]
    for name in found:
        found += [joint.child for joint in robot.below(name) if not stops(joint)]
    return found


def _tool_of(robot: UrdfRobot, last_link: str) -> str:
    """The frame of the tool by its name, or the last frame that is fixed to the last link."""
    fixed = fixed_to(robot, last_link)
    for pattern in TOOL_NAMES:
        named = [name for name in fixed if re.search(pattern, name, re.IGNORECASE)]
        if named:
            return named[-1]
    return fixed[-1]


def _locked(robot: UrdfRobot, way: list[Joint], positions: Mapping[str, float]) -> list[Locked]:
    arm = {joint.name for joint in way}
    others = {joint.name: joint for joint in robot.joints if joint.kind != "fixed" and joint.name not in arm}
    for name in positions:
        if name not in others:
            raise ConfigError(f"--lock {name}: no such joint can be locked; there are {', '.join(others) or 'none'}")
    return [Locked(name, _position(j, others, positions), _why(j)) for name, j in others.items()]


def _why(joint: Joint) -> str:
    if joint.mimic is not None:
        return f"follows {joint.mimic.joint}"
    return "a gripper's" if _is_finger(joint) else "not between base and tool"


def _position(joint: Joint, others: Mapping[str, Joint], positions: Mapping[str, float]) -> float:
    """Return where a joint is locked: as given, where the joint that it follows is, or nearest to zero."""
    if joint.kind in FREE:
        return 0.0
    if joint.name in positions:
        return positions[joint.name]
    mimic = joint.mimic
    if mimic is not None and (leader := others.get(mimic.joint)) is not None and leader.mimic is None:
        return mimic.factor * _position(leader, others, positions) + mimic.offset
    if joint.kind == "continuous":
        return 0.0
    lower, upper = joint.limit.lower or 0.0, joint.limit.upper or 0.0
    return min(max(0.0, min(lower, upper)), max(lower, upper))


def _fixed(robot: UrdfRobot, positions: Mapping[str, float]) -> UrdfRobot:
    """The same with these joints fixed where they are locked."""
    joints = tuple(_as_fixed(j, positions[j.name]) if j.name in positions else j for j in robot.joints)
    return replace(robot, joints=joints)


def _as_fixed(joint: Joint, position: float) -> Joint:
    moved: Array = np.eye(4)
    if joint.kind == "prismatic":
        moved = transform(np.eye(3), position * joint.axis)
    elif joint.kind in MOVING:
        moved = transform(rotation_from_vector(position * joint.axis), np.zeros(3))
    return replace(joint, kind="fixed", parent_T_joint=joint.parent_T_joint @ moved, mimic=None)
