"""A URDF's text as a description; every mistake that a cure is known for is said with it."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import get_args
from xml.etree import ElementTree

import numpy as np

from common.errors import ModelError
from common.geometry import Array, rotation_from_vector, transform
from common.text import name_mistake
from farhand.arm_import.description.elements import (
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    JointKind,
    Limit,
    Mimic,
    Rgba,
    Shape,
    Sphere,
    UrdfBox,
    UrdfLink,
    UrdfMesh,
    UrdfRobot,
)
from remote_site.kinematics.model import ASSUMED, named_twice

Element = ElementTree.Element
XACRO = "xacro"
ASSUMABLE = ("effort", "jerk")
NAMES: Mapping[str, Sequence[str]] = {  # of each element, the attributes that are names
    "robot": ("name",),
    "link": ("name",),
    "joint": ("name", "type"),
    "parent": ("link",),
    "child": ("link",),
    "mimic": ("joint",),
    "material": ("name",),
}
TURNING = ("revolute", "prismatic", "continuous")
MOST_LINKS, MOST_MOVING = 500, 200  # a humanoid with both hands has half as many


def read_description(text: bytes, source: str) -> UrdfRobot:
    """The links and joints of a URDF's bytes; ModelError names `source`, what is wrong, and the cure."""
    try:
        robot = ElementTree.fromstring(text)  # noqa: S314  # the robot model is the user's own
    except ElementTree.ParseError as error:
        raise ModelError(f"{source} is not XML: {error}; give a URDF file") from error
    if source.endswith(f".{XACRO}") or any(XACRO in element.tag for element in robot.iter()):
        urdf = source.removesuffix(f".{XACRO}").removesuffix(".urdf")
        made = f"{urdf}-expanded.urdf" if source == f"{urdf}.urdf" else f"{urdf}.urdf"
        raise ModelError(f"{source} is a xacro file; make the URDF of it first: xacro {source} -o {made}")
    if robot.tag != "robot":
        kind = "MuJoCo's own format (MJCF)" if robot.tag == "mujoco" else f"<{robot.tag}>"
        raise ModelError(f"{source} is {kind}, not a URDF, whose first element is <robot>; give the arm's URDF")
    _check_names(robot, source)
    if twice := named_twice(robot):
        raise ModelError(f"{source}: {twice}")
    colours = {name: rgba for m in robot.findall("material") if (name := m.get("name")) and (rgba := _rgba(m))}
    links = {link.name: link for link in (_link(e, colours, source) for e in robot.findall("link"))}
    joints = tuple(_joint(e, source) for e in robot.findall("joint"))
    _check_size(links, joints, source)
    return UrdfRobot(robot.get("name") or "arm", _root(links, joints, source), links, joints)


def _check_names(robot: Element, source: str) -> None:
    """ModelError for a name that would not stay one where it is written: too long, or with line ends and the like."""
    numbers: Counter[str] = Counter()
    for element in robot.iter():
        numbers[element.tag] += 1
        place = f"{source}: <{element.tag}> number {numbers[element.tag]} in the file"
        for key in NAMES.get(element.tag, ()):
            if wrong := name_mistake(element.get(key) or ""):
                raise ModelError(f"{place}: its {key} {wrong}")
        if element.tag == "mesh" and not (element.get("filename") or "").isprintable():
            raise ModelError(f"{place}: its filename has characters that do not show; rename the file, and name it so")


def _check_size(links: dict[str, UrdfLink], joints: tuple[Joint, ...], source: str) -> None:
    """ModelError for more than any robot has: each would be weighed, and moved beside each other."""
    moving = sum(joint.kind in TURNING for joint in joints)
    if len(links) > MOST_LINKS or moving > MOST_MOVING:
        raise ModelError(
            f"{source} has {len(links)} links and {moving} moving joints, at most {MOST_LINKS} and {MOST_MOVING} can "
            "be imported; give the file of the arm alone"
        )


def _root(links: dict[str, UrdfLink], joints: tuple[Joint, ...], source: str) -> str:
    """The link that no joint carries; ModelError where the links are no tree."""
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                raise ModelError(f"{source}: joint {joint.name} names the link {end!r}, which does not exist; add it")
    carried = Counter(joint.child for joint in joints)
    twice = [name for name, times in carried.items() if times > 1]
    if twice:
        raise ModelError(f"{source}: {', '.join(twice)} is the child of two joints; a URDF is a tree, remove one")
    roots = [name for name in links if name not in carried]
    if not roots:
        raise ModelError(f"{source} has no link that everything else hangs from; give a URDF whose joints are a tree")
    if len(roots) > 1:
        raise ModelError(f"{source}: {', '.join(roots)} are not joined to each other; join them by fixed joints")
    return roots[0]


def _link(element: Element, colours: dict[str, Rgba], source: str) -> UrdfLink:
    name = element.get("name") or ""
    shapes = {
        kind: tuple(shape for e in element.findall(kind) if (shape := _shape(e, colours, f"{source}: link {name}")))
        for kind in ("visual", "collision")
    }
    return UrdfLink(name, shapes["visual"], shapes["collision"], _inertial(element.find("inertial"), source))


def _shape(element: Element, colours: dict[str, Rgba], where: str) -> Shape | None:
    geometry = element.find("geometry")
    found = None if geometry is None else _geometry(geometry, where)
    if found is None:
        return None
    material = element.find("material")
    colour = None if material is None else _rgba(material) or colours.get(material.get("name") or "")
    return Shape(_pose(element.find("origin"), where), found, colour)


def _geometry(geometry: Element, where: str) -> Geometry | None:
    """The first geometry that is known; None where there is none, as for a capsule, which URDF has not."""
    for kind in geometry:
        if kind.tag == "mesh":
            x, y, z = _numbers(kind.get("scale") or "1 1 1", 3, where)
            return UrdfMesh((kind.get("filename") or "").strip(), (x, y, z))
        if kind.tag == "box":
            x, y, z = _numbers(kind.get("size") or "", 3, where)
            return UrdfBox((x, y, z))
        if kind.tag == "cylinder":
            return Cylinder(_number(kind.get("radius"), where), _number(kind.get("length"), where))
        if kind.tag == "sphere":
            return Sphere(_number(kind.get("radius"), where))
    return None


def _joint(element: Element, source: str) -> Joint:
    name = element.get("name") or ""
    where = f"{source}: joint {name}"
    kind = element.get("type") or ""
    if kind not in get_args(JointKind):
        raise ModelError(f"{where} has the type {kind!r}; the types are {', '.join(get_args(JointKind))}")
    axis = element.find("axis")
    dynamics = element.find("dynamics")
    given = {} if dynamics is None else dynamics.attrib
    return Joint(
        name,
        kind,  # type: ignore[arg-type]  # checked above
        _end(element, "parent", where),
        _end(element, "child", where),
        _pose(element.find("origin"), where),
        _axis("1 0 0" if axis is None else axis.get("xyz") or "", kind, where),
        _limit(element.find("limit"), where),
        _mimic(element.find("mimic"), where),
        _number(given.get("damping", "0"), where),
        _number(given.get("friction", "0"), where),
    )


def _end(element: Element, which: str, where: str) -> str:
    end = element.find(which)
    name = None if end is None else end.get("link")
    if not name:
        raise ModelError(f'{where} needs <{which} link="…"/>')
    return name


def _axis(text: str, kind: str, where: str) -> Array:
    axis = _numbers(text, 3, where)
    length = math.sqrt(float(axis @ axis))
    if length == 0.0 and kind in TURNING:
        raise ModelError(f'{where} needs <axis xyz="…"/>, three numbers that are not all zero')
    return axis / length if length else axis


def _limit(element: Element | None, where: str) -> Limit:
    if element is None:
        return Limit()
    keys = ("lower", "upper", "velocity", "effort", "acceleration", "jerk")
    stated = [key for key in keys if element.get(key) is not None and not _is_assumed(element, key)]
    return Limit(**{key: _number(element.get(key), where) for key in stated})


def _is_assumed(element: Element, key: str) -> bool:
    """Return whether an earlier import assumed this, since its maker's file states none."""
    return key in ASSUMABLE and element.get(key) == element.get(f"{ASSUMED}{key}")


def _mimic(element: Element | None, where: str) -> Mimic | None:
    if element is None:
        return None
    factor, offset = (_number(element.get(key, usual), where) for key, usual in (("multiplier", "1"), ("offset", "0")))
    return Mimic(element.get("joint") or "", factor, offset)


def _inertial(element: Element | None, where: str) -> Inertial | None:
    """Read mass and inertia as stated; None where the file states nothing, or no mass."""
    mass = None if element is None else element.find("mass")
    inertia = None if element is None else element.find("inertia")
    if element is None or mass is None or inertia is None:
        return None
    ixx, iyy, izz, ixy, ixz, iyz = (
        _number(inertia.get(key, "0"), where) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    pose = _pose(element.find("origin"), where)
    turned = pose[:3, :3]
    matrix = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return Inertial(_number(mass.get("value"), where), pose[:3, 3], turned @ matrix @ turned.T)


def _pose(origin: Element | None, where: str) -> Array:
    """An <origin> as a pose (4 x 4): turned about the fixed x, then y, then z."""
    if origin is None:
        return np.eye(4)
    roll, pitch, yaw = _numbers(origin.get("rpy") or "0 0 0", 3, where)
    about_x, about_y, about_z = (
        rotation_from_vector(angle * axis) for angle, axis in zip((roll, pitch, yaw), np.eye(3), strict=True)
    )
    return transform(about_z @ about_y @ about_x, _numbers(origin.get("xyz") or "0 0 0", 3, where))


def _rgba(material: Element) -> Rgba | None:
    colour = material.find("color")
    words = [] if colour is None else (colour.get("rgba") or "").split()
    if len(words) != 4:
        return None
    r, g, b, a = (_float(word) for word in words)
    return r, g, b, a


def _numbers(text: str, count: int, where: str) -> Array:
    numbers = np.array(list(map(_float, text.split())))
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ModelError(f"{where}: {text!r} must be {count} numbers with spaces between them")
    return numbers


def _number(text: str | None, where: str) -> float:
    value = _float(text or "")
    if not math.isfinite(value):
        raise ModelError(f"{where}: {text!r} must be a number")
    return value


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
