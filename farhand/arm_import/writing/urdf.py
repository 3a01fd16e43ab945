"""An arm as the text of a URDF in which only its joints move, and its meshes as files of one folder beside it; pure."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePath
from xml.sax.saxutils import quoteattr

import numpy as np

from common.geometry import Array
from common.text import MOST_OF_NAME, file_name, in_xml_comment
from farhand.arm_import.description.elements import (
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    Limit,
    Rgba,
    Shape,
    Sphere,
    UrdfBox,
    UrdfLink,
    UrdfMesh,
    UrdfRobot,
)

GREY: Rgba = (0.75, 0.77, 0.80, 1.0)
DIGITS = 9


def urdf_text(robot: UrdfRobot, comment: Sequence[str]) -> str:
    """The file, which begins with the lines of a comment."""
    lines = ['<?xml version="1.0"?>', "<!--", *(f"  {in_xml_comment(line)}" for line in comment), "-->"]
    lines.append(f"<robot name={quoteattr(robot.name)}>")
    for link in robot.links.values():
        lines += _link(link)
    for joint in robot.joints:
        lines += _joint(joint)
    return "\n".join([*lines, "</robot>", ""])


def _link(link: UrdfLink) -> list[str]:
    inside = [] if link.inertial is None else _inertial(link.inertial)
    for kind, shapes in (("visual", link.visuals), ("collision", link.collisions)):
        inside += [line for shape in shapes for line in _shape(kind, shape)]
    name = quoteattr(link.name)
    return [f"  <link name={name}>", *inside, "  </link>"] if inside else [f"  <link name={name}/>"]


def _inertial(inertial: Inertial) -> list[str]:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertial.inertia_kg_m2.tolist()
    moments = {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}
    return [
        "    <inertial>",
        f"      <origin xyz={_attribute(inertial.centre_m.tolist())}/>",
        f"      <mass value={_attribute([inertial.mass_kg])}/>",
        f"      <inertia {' '.join(f'{key}={_attribute([value])}' for key, value in moments.items())}/>",
        "    </inertial>",
    ]


def _shape(kind: str, shape: Shape) -> list[str]:
    colour = shape.colour or GREY
    material = f'<material name=""><color rgba={_attribute(colour)}/></material>' if kind == "visual" else ""
    origin = _origin(shape.link_T_shape)
    return [f"    <{kind}>{origin}<geometry>{_geometry(shape.geometry)}</geometry>{material}</{kind}>"]


def _geometry(geometry: Geometry) -> str:
    if isinstance(geometry, UrdfMesh):
        scale = "" if geometry.scale == (1.0, 1.0, 1.0) else f" scale={_attribute(geometry.scale)}"
        return f"<mesh filename={quoteattr(geometry.filename)}{scale}/>"
    if isinstance(geometry, UrdfBox):
        return f"<box size={_attribute(geometry.size_m)}/>"
    if isinstance(geometry, Cylinder):
        return f"<cylinder radius={_attribute([geometry.radius_m])} length={_attribute([geometry.length_m])}/>"
    assert isinstance(geometry, Sphere)  # noqa: S101  # the last that there is
    return f"<sphere radius={_attribute([geometry.radius_m])}/>"


def _joint(joint: Joint) -> list[str]:
    head = f"  <joint name={quoteattr(joint.name)} type={quoteattr(joint.kind)}>"
    ends = f"<parent link={quoteattr(joint.parent)}/><child link={quoteattr(joint.child)}/>"
    inside = [f"    {ends}{_origin(joint.parent_T_joint)}"]
    if joint.kind != "fixed":
        inside.append(f"    <axis xyz={_attribute(joint.axis.tolist())}/>{_limit(joint.limit, joint.marks)}")
    return [head, *inside, "  </joint>"]


def _limit(limit: Limit, marks: Mapping[str, float]) -> str:
    stated = {key: getattr(limit, key) for key in Limit.__dataclass_fields__} | dict(marks)
    given = " ".join(f"{key}={_attribute([value])}" for key, value in stated.items() if value is not None)
    return f"<limit {given}/>"


def _origin(pose: Array) -> str:
    turn, place = _roll_pitch_yaw(pose[:3, :3]), pose[:3, 3].tolist()
    if not any(turn) and not any(place):
        return ""
    rpy = f" rpy={_attribute(turn)}" if any(turn) else ""
    return f"<origin xyz={_attribute(place)}{rpy}/>"


def _roll_pitch_yaw(rotation: Array) -> list[float]:
    """The angles about the fixed x, y and z, in this order, rad."""
    r = rotation
    level = math.hypot(r[0, 0], r[1, 0])
    pitch = math.atan2(-r[2, 0], level)
    if level < 1e-9:  # x points straight up or down: all of the turn about it is roll
        return [math.atan2(-r[1, 2], r[1, 1]), pitch, 0.0]
    return [math.atan2(r[2, 1], r[2, 2]), pitch, math.atan2(r[1, 0], r[0, 0])]


def _attribute(numbers: Iterable[float]) -> str:
    return quoteattr(" ".join(f"{np.round(number, DIGITS) + 0.0:.{DIGITS}g}" for number in numbers))


def gather_meshes(robot: UrdfRobot, folder: str) -> tuple[UrdfRobot, dict[str, Path]]:
    """The robot with every mesh named as a file of `folder`, and by these names the files that it names now."""
    names: dict[str, str] = {}

    def moved(shape: Shape) -> Shape:
        mesh = shape.geometry
        if not isinstance(mesh, UrdfMesh):
            return shape
        if mesh.filename not in names:
            names[mesh.filename] = f"{folder}/{_free_name(PurePath(mesh.filename), names.values())}"
        return replace(shape, geometry=replace(mesh, filename=names[mesh.filename]))

    links = {name: _with_shapes(link, moved) for name, link in robot.links.items()}
    return replace(robot, links=links), {name: Path(file) for file, name in names.items()}


def _with_shapes(link: UrdfLink, moved: Callable[[Shape], Shape]) -> UrdfLink:
    return replace(link, visuals=tuple(map(moved, link.visuals)), collisions=tuple(map(moved, link.collisions)))


def _free_name(file: PurePath, taken: Collection[str]) -> str:
    """The file's own name, numbered where another has its stem: MuJoCo knows a mesh by that, and case may not count."""
    stems = {PurePath(name).stem.lower() for name in taken}
    own = PurePath(file_name(file.name))
    stem, number = own.stem[:MOST_OF_NAME], 1
    while stem.lower() in stems:
        number += 1
        stem = f"{own.stem[:MOST_OF_NAME]}_{number}"
    return f"{stem}{own.suffix}"
