"""The arm as its URDF describes it: joints, limits, the tool centre point's pose and Jacobian."""

import math
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Self
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from common.errors import ModelError
from common.geometry import Array
from remote_site.kinematics.config import UNSTATED_JERK_RAD_S3

IMPORT = "farhand arm import {urdf} --out arm.toml"  # makes what Farhand reads of a URDF as its maker publishes it
# Before the name of a <limit>'s attribute: the value that the import gave it, counting until it is corrected there.
ASSUMED, GIVEN = "assumed_", "given_"
BOUNDED_JOINTS = ("JointModelR", "JointModelP")
BOUNDED = ("revolute", "prismatic")  # URDF joint types that must have limits
MOVING = (*BOUNDED, "continuous")
AXES = 3


@dataclass(frozen=True, slots=True)
class LinkGeometry:
    """A joint's frame in the one before it (4 x 4), and the axis in its own that it turns about or slides along."""

    parent_T_joint: Array
    axis: tuple[float, float, float]
    slides: bool


class ArmModel:
    """A serial arm of one-degree joints; one instance serves one thread, since its workspace is reused.

    `joint_names` is the order of every joint vector; `lower`, `upper` (rad) and `velocity` (rad/s) are the
    URDF's limits, each (n,); so are `effort` (N m, or N of a joint that slides), `acceleration` (rad/s²), inf where the
    URDF gives none, and `jerk` (rad/s³), 100 for the joints `without_jerk`.
    """

    def __init__(self, model: pin.Model, tcp_frame: int, limits: list[dict[str, str]]) -> None:
        """`limits` are the attributes of each joint's <limit>, of which pinocchio does not read all."""
        self.acceleration: Array = np.array([float(limit.get("acceleration", "inf")) for limit in limits])
        self.jerk: Array = np.array([float(limit.get("jerk", UNSTATED_JERK_RAD_S3)) for limit in limits])
        self._stated = limits
        self.pin_model = model
        self.joint_names = tuple(model.names)[1:]
        stated = zip(self.joint_names, limits, strict=True)
        self.without_jerk = tuple(name for name, limit in stated if "jerk" not in limit)
        self.lower: Array = np.array(model.lowerPositionLimit)
        self.upper: Array = np.array(model.upperPositionLimit)
        self.velocity: Array = np.array(model.velocityLimit)
        self.effort: Array = np.array(model.effortLimit)
        self._data = model.createData()
        self.tcp_frame = tcp_frame

    @classmethod
    def from_urdf(cls, path: Path, tool_frame: str, tool_T_tcp: Array) -> Self:
        """Read a URDF; ModelError states what makes it unusable and how to cure it."""
        written = _read_joints(path)
        try:
            model = pin.buildModelFromUrdf(str(path))
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"cannot read the robot model {path}: {error}; give a URDF file") from error
        _check_joints(path, model)
        if not model.existFrame(tool_frame):
            known = ", ".join(frame.name for frame in model.frames)
            raise ModelError(f"{path} has no frame {tool_frame!r}; set robot.tool_frame to one of: {known}")
        if not np.isfinite(tool_T_tcp).all():
            raise ModelError("the tool centre point's offset must be finite; correct robot.tool_offset_m")
        parent_id = model.getFrameId(tool_frame)
        parent = model.frames[parent_id]
        placement = parent.placement * pin.SE3(tool_T_tcp)
        tcp = pin.Frame("tool_centre_point", parent.parentJoint, parent_id, placement, pin.FrameType.OP_FRAME)
        return cls(model, int(model.addFrame(tcp)), [_limit(written[name]) for name in tuple(model.names)[1:]])

    def marked(self, mark: str, key: str) -> dict[str, float]:
        """By joint the values that a URDF marks as ASSUMED or GIVEN by the import, of one attribute of its limits."""
        stated = zip(self.joint_names, self._stated, strict=True)
        return {name: _number(limit[mark + key]) for name, limit in stated if mark + key in limit}

    def forward(self, q: Array) -> Array:
        """The tool centre point's pose `base_T_tool` (4 x 4) at joint positions (n,) in rad."""
        pin.forwardKinematics(self.pin_model, self._data, q)
        pose: Array = pin.updateFramePlacement(self.pin_model, self._data, self.tcp_frame).homogeneous
        return pose

    def geometry(self) -> tuple[list[LinkGeometry], Array]:
        """Every joint's frame and axis, and the tool centre point in the last joint's frame (4 x 4): enough to draw."""
        model, links = self.pin_model, []
        for k in range(1, model.njoints):
            joint, data = model.joints[k], model.joints[k].createData()
            joint.calc(data, np.zeros(1))
            motion: list[float] = np.array(data.S).ravel().tolist()
            slides = joint.shortname().startswith("JointModelP")
            x, y, z = motion[:3] if slides else motion[3:]
            links.append(LinkGeometry(model.jointPlacements[k].homogeneous, (x, y, z), slides))
        last_T_tool: Array = model.frames[self.tcp_frame].placement.homogeneous
        return links, last_T_tool

    def position(self, q: Array) -> Array:
        """The tool centre point (3,) in m in the base's axes at joint positions (n,) in rad."""
        pin.forwardKinematics(self.pin_model, self._data, q)
        position: Array = pin.updateFramePlacement(self.pin_model, self._data, self.tcp_frame).translation
        return position

    def jacobian(self, q: Array) -> Array:
        """The Jacobian (6 x n) of the tool centre point: linear (m/s), then angular (rad/s), in the base's axes."""
        jacobian: Array = pin.computeFrameJacobian(
            self.pin_model, self._data, q, self.tcp_frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        return jacobian

    def levers(self, outer: int, corners: Array) -> list[float]:
        """The most that a body can move per rad (or m) of each joint, m, 0 for those beyond it.

        `corners` (m x 3) span it in the frame of joint `outer` (from 1; 0 is the base). A rotation moves a point by no
        more than its distance from the axis: exact for the outermost joint, a sum of link lengths for the others.
        """
        links, _ = self.geometry()
        levers, about, beyond = [0.0] * len(links), corners, 0.0
        for joint in range(outer, 0, -1):
            link = links[joint - 1]
            away = float(np.linalg.norm(np.cross(about, link.axis), axis=1).max())
            levers[joint - 1] = 1.0 if link.slides else away + beyond
            beyond += float(np.linalg.norm(about, axis=1).max())
            beyond += max(abs(self.lower[joint - 1]), abs(self.upper[joint - 1])) if link.slides else 0.0
            about = link.parent_T_joint[None, :3, 3]
        return levers

    @property
    def reach(self) -> tuple[Array, Array]:
        """Two corners (3,) in m in the base's axes between which the tool centre point always is.

        What the first joint alone moves keeps its way along that joint's axis; the rest may point anywhere.
        """
        links, last_T_tool = self.geometry()
        frames = [*(link.parent_T_joint for link in links), last_T_tool]
        axis = frames[0][:3, :3] @ np.array(links[0].axis)
        offset = frames[0][:3, :3] @ frames[1][:3, 3]
        slides = [link.slides for link in links]
        way = np.maximum(np.abs(self.lower), np.abs(self.upper)) * slides
        beyond = sum(float(np.linalg.norm(frame[:3, 3])) for frame in frames[2:]) + float(way[1:].sum())
        if slides[0]:
            centre, about = frames[0][:3, 3] + offset, way[0] * np.abs(axis)
        else:
            centre = frames[0][:3, 3] + axis * float(axis @ offset)
            about = np.linalg.norm(np.cross(offset, axis)) * np.sqrt(np.maximum(1.0 - axis * axis, 0.0))
        return centre - about - beyond, centre + about + beyond

    @property
    def tool_frame(self) -> str:
        """The frame that carries the tool."""
        frames = self.pin_model.frames
        return str(frames[frames[self.tcp_frame].parentFrame].name)

    @property
    def tcp_levers(self) -> list[float]:
        """The most by which each joint can move the tool centre point, m per rad (or m)."""
        tcp = self.pin_model.frames[self.tcp_frame].placement.translation
        return self.levers(len(self.joint_names), tcp[None])


def named_twice(robot: ElementTree.Element) -> str:
    """Say what is wrong, and its cure, where two links or two joints of a URDF have one name; else nothing."""
    for kind in ("link", "joint"):
        counted = Counter(element.get("name", "") for element in robot.findall(kind))
        if twice := [name for name, times in counted.items() if times > 1]:
            return f"two {kind}s are called {twice[0]}; rename one"
    return ""


def _read_joints(path: Path) -> dict[str, ElementTree.Element]:
    """The joint elements by name; ModelError names a joint that pinocchio would refuse without naming it."""
    try:
        root = ElementTree.parse(path).getroot()  # noqa: S314  # the robot model is the site's own
    except (OSError, ElementTree.ParseError) as error:
        raise ModelError(f"cannot read the robot model {path}: {error}; give a URDF file") from error
    if twice := named_twice(root):
        raise ModelError(f"{path}: {twice}")
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    for name, joint in joints.items():
        if joint.get("type") in MOVING:
            _check_axis(path, name, joint)
        if joint.get("type") in BOUNDED:
            _check_limits(path, name, joint)
    return joints


def _check_axis(path: Path, name: str, joint: ElementTree.Element) -> None:
    axis = joint.find("axis")
    xyz = [_number(text) for text in ("1 0 0" if axis is None else axis.get("xyz", "")).split()]
    if not (len(xyz) == AXES and math.isfinite(sum(xyz)) and any(xyz)):
        raise ModelError(f'{path}: joint {name} needs <axis xyz="…"/>, three numbers that are not all zero')


def _check_limits(path: Path, name: str, joint: ElementTree.Element) -> None:
    given = _limit(joint)
    lower, upper = (_number(given.get(key, "0")) for key in ("lower", "upper"))
    velocity, effort = (_number(given.get(key, "nan")) for key in ("velocity", "effort"))
    acceleration, jerk = _number(given.get("acceleration", "inf")), _number(given.get("jerk", "1"))
    finite = math.isfinite(lower + upper + velocity + effort + jerk)
    if not (finite and lower < upper and min(velocity, effort, jerk) > 0 and acceleration > 0):
        form = '<limit lower="…" upper="…" velocity="…" effort="…"/>'
        cure = "all finite, lower below upper, the others above 0, as acceleration and jerk where they are stated"
        raise ModelError(f"{path}: joint {name} needs {form}, {cure}")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _limit(joint: ElementTree.Element) -> dict[str, str]:
    """The attributes of a joint's <limit>."""
    limit = joint.find("limit")
    return {} if limit is None else limit.attrib


def _check_joints(path: Path, model: pin.Model) -> None:
    kinds = [joint.shortname() for joint in model.joints][1:]
    unfit = [name for name, kind in zip(tuple(model.names)[1:], kinds, strict=True) if not _is_bounded(kind)]
    if not kinds:
        raise ModelError(f"{path} has no moving joint; give the URDF of an arm")
    if unfit:
        change = f"change the joint type, or let it be changed: {IMPORT.format(urdf=path)}"
        raise ModelError(f"{path}: {', '.join(unfit)} must be revolute or prismatic with limits; {change}")
    if any(model.parents[i] != i - 1 for i in range(1, model.njoints)):
        lock = f"lock the joints that are not the arm's (gripper fingers): {IMPORT.format(urdf=path)}"
        raise ModelError(f"{path} branches; {lock}")


def _is_bounded(kind: str) -> bool:
    return kind.startswith(BOUNDED_JOINTS) and not kind.startswith("JointModelRUB") and "Unbounded" not in kind
