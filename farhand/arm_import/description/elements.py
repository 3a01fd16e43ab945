"""A URDF's links and joints as values, in the file's order; pure."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

from common.geometry import Array

Rgba: TypeAlias = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class UrdfMesh:
    """A mesh by its name in the file, and its scale along its own axes."""

    filename: str
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True)
class UrdfBox:
    """A box by its edges, m."""

    size_m: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along its own z, m."""

    radius_m: float
    length_m: float


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere, m."""

    radius_m: float


Geometry: TypeAlias = UrdfMesh | UrdfBox | Cylinder | Sphere


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A geometry at its pose (4 x 4) in the link's frame; its colour where the file gives one."""

    link_T_shape: Array
    geometry: Geometry
    colour: Rgba | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Inertial:
    """Mass in kg, centre of mass (3,) in m and inertia (3 x 3) in kg m² about it, in the link's axes."""

    mass_kg: float
    centre_m: Array
    inertia_kg_m2: Array


@dataclass(frozen=True, slots=True, eq=False)
class UrdfLink:
    """A link with its shapes."""

    name: str
    visuals: tuple[Shape, ...] = ()
    collisions: tuple[Shape, ...] = ()
    inertial: Inertial | None = None


@dataclass(frozen=True, slots=True)
class Limit:
    """The values of a joint's <limit>, None where it states none: rad or m, and their derivatives by s; N m or N."""

    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None
    acceleration: float | None = None
    jerk: float | None = None


@dataclass(frozen=True, slots=True)
class Mimic:
    """A joint that follows another: position = factor · the other's + offset."""

    joint: str
    factor: float = 1.0
    offset: float = 0.0


JointKind: TypeAlias = Literal["fixed", "revolute", "continuous", "prismatic", "floating", "planar", "spherical"]


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """A joint: its frame (4 x 4) in the parent link's, and the axis (3,) in its own.

    `marks` are what <limit> says of its own values besides: which were assumed, and as what.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    parent_T_joint: Array
    axis: Array
    limit: Limit = Limit()
    mimic: Mimic | None = None
    damping: float = 0.0
    friction: float = 0.0
    marks: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class UrdfRobot:
    """A robot as its file describes it: a tree of links, joined by `joints`, that begins at `root`."""

    name: str
    root: str
    links: dict[str, UrdfLink] = field(default_factory=dict)
    joints: tuple[Joint, ...] = ()

    def above(self, link: str) -> Joint | None:
        """The joint that carries a link; None for the root."""
        return next((joint for joint in self.joints if joint.child == link), None)

    def below(self, link: str) -> list[Joint]:
        """The joints that a link carries."""
        return [joint for joint in self.joints if joint.parent == link]

    def way_to(self, link: str) -> list[Joint]:
        """The joints from the root to a link."""
        way: list[Joint] = []
        joint = self.above(link)
        while joint is not None:
            way.insert(0, joint)
            joint = self.above(joint.parent)
        return way

    def beyond(self, link: str) -> list[str]:
        """A link and all that hang from it."""
        found = [link]
        for name in found:
            found += [joint.child for joint in self.below(name)]
        return found


def with_free_names(robot: UrdfRobot, taken: Collection[str]) -> UrdfRobot:
    """The same with other names for links and joints that have a name that is taken."""

    def free(name: str) -> str:
        return f"{name}_of_{robot.name}" if name in taken else name

    links = {free(name): replace(link, name=free(name)) for name, link in robot.links.items()}
    joints = tuple(
        replace(
            joint,
            name=free(joint.name),
            parent=free(joint.parent),
            child=free(joint.child),
            mimic=None if joint.mimic is None else replace(joint.mimic, joint=free(joint.mimic.joint)),
        )
        for joint in robot.joints
    )
    return replace(robot, root=free(robot.root), links=links, joints=joints)
