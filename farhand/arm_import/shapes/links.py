"""Every link with what can be shown of it and the shapes that keep their distance, meshes read from their files."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from common.errors import ModelError
from common.geometry import Array
from farhand.arm_import.description.elements import Inertial, Shape, UrdfLink, UrdfMesh
from farhand.arm_import.shapes.capsule import Capsule
from farhand.arm_import.shapes.capsules_of import capsule_of, outermost, shape_of
from farhand.arm_import.shapes.covering import covering
from farhand.arm_import.shapes.meshes import read_triangles, shown

FindFile = Callable[[str], Path]
NOWHERE: Array = np.zeros((0, 3))
DENSITY_KG_M3 = 1500.0  # of a link by the volume of its capsules: between a UR5's and an iiwa's
LEAST_MASS_KG, LEAST_INERTIA_KG_M2 = 1e-4, 1e-7
EMPTY = Inertial(0.1, np.zeros(3), 1e-4 * np.eye(3))


def usable(inertial: Inertial | None) -> bool:
    """Return whether mass and inertia are those of a body: positive, no moment above the sum of the two others."""
    if inertial is None or not inertial.mass_kg >= LEAST_MASS_KG or not np.isfinite(inertial.inertia_kg_m2).all():
        return False
    moments = np.linalg.eigvalsh(inertial.inertia_kg_m2)
    return bool(moments[0] >= LEAST_INERTIA_KG_M2 and moments[0] + moments[1] >= moments[2] * (1 - 1e-6))


def estimated(capsules: Sequence[Capsule]) -> Inertial:
    """Of a link whose file states none: as if its capsules were solid; small where it has none."""
    if not capsules:
        return EMPTY
    masses = [DENSITY_KG_M3 * capsule.volume for capsule in capsules]
    middles = [(capsule.start + capsule.end) / 2 for capsule in capsules]
    centre = np.average(middles, axis=0, weights=masses)
    about = [_rod(c, m) + _moved(m, at - centre) for c, m, at in zip(capsules, masses, middles, strict=True)]
    return Inertial(float(sum(masses)), centre, np.sum(about, axis=0))


def mended(inertial: Inertial) -> Inertial | None:
    """With the mean of its moments about all axes where the file's are those of no body; None without a mass."""
    mean = float(np.abs(np.linalg.eigvalsh(inertial.inertia_kg_m2)).mean())
    if inertial.mass_kg < LEAST_MASS_KG or not mean >= LEAST_INERTIA_KG_M2:
        return None
    return Inertial(inertial.mass_kg, inertial.centre_m, mean * np.eye(3))


def _rod(capsule: Capsule, mass: float) -> Array:
    """The inertia (3 x 3) of a solid cylinder of the capsule's length and radius about its middle."""
    along = capsule.end - capsule.start
    length = float(np.sqrt(along @ along)) + capsule.radius
    axis = along / np.sqrt(along @ along) if along.any() else np.eye(3)[2]
    lengthways, across = mass * capsule.radius**2 / 2, mass * (3 * capsule.radius**2 + length**2) / 12
    rod: Array = across * np.eye(3) + (lengthways - across) * np.outer(axis, axis)
    return rod


def _moved(mass: float, by: Array) -> Array:
    moved: Array = mass * (float(by @ by) * np.eye(3) - np.outer(by, by))
    return moved


@dataclass(frozen=True, slots=True, eq=False)
class CoveredLink:
    """A link whose shapes are no meshes, and whose visuals are files that MuJoCo shows; `notes` say what differs.

    `points` (m x 3) in m, in its frame, are those of the file's own shapes, which capsules reach beyond.
    """

    link: UrdfLink
    points: Array
    notes: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()  # visuals
    estimated: bool = False  # mass and inertia


@dataclass(slots=True)
class _Notes:
    said: list[str] = field(default_factory=list)
    dropped: list[str] = field(default_factory=list)


def cover_link(link: UrdfLink, find: FindFile, *, moves: bool) -> CoveredLink:
    """The link as it is written; ModelError where a collision mesh is missing or cannot be read.

    A link that `moves` gets a mass and an inertia where its file states none that a body can have.
    """
    notes = _Notes()
    visuals = _visuals(link, find, notes)
    shapes, points = _covered(link.collisions, find, link.name)
    if not shapes and link.visuals:
        shapes, points = _of_visuals(link, find, notes)
    inertial, is_estimated = link.inertial, False
    if moves and not usable(inertial):
        inertial, is_estimated = _inertial(link, shapes, notes)
    covered = UrdfLink(link.name, tuple(visuals), tuple(shapes), inertial)
    return CoveredLink(covered, points, tuple(notes.said), tuple(notes.dropped), is_estimated)


def with_hulls(covered: CoveredLink, link: UrdfLink, find: FindFile) -> CoveredLink:
    """The same with its collision meshes, which count as their convex hulls, instead of capsules around them."""
    own = [_found(shape, shape.geometry, find) for shape in link.collisions if isinstance(shape.geometry, UrdfMesh)]
    simple = [shape for shape in link.collisions if not isinstance(shape.geometry, UrdfMesh)]
    return replace(covered, link=replace(covered.link, collisions=(*simple, *own)))


def _found(shape: Shape, mesh: UrdfMesh, find: FindFile) -> Shape:
    return Shape(shape.link_T_shape, UrdfMesh(str(find(mesh.filename)), mesh.scale))


def _inertial(link: UrdfLink, shapes: Sequence[Shape], notes: _Notes) -> tuple[Inertial, bool]:
    if link.inertial is not None and (better := mended(link.inertial)) is not None:
        notes.said.append(f"{link.name}: no body has the file's inertia; its mean about every axis counts instead")
        return better, False
    return estimated([capsule_of(shape) for shape in shapes]), True


def _visuals(link: UrdfLink, find: FindFile, notes: _Notes) -> list[Shape]:
    """Return the shapes that MuJoCo can show; instead of visuals that it cannot, the link's collision meshes."""
    kept = [shape for one in link.visuals if (shape := _shown(one, find, notes)) is not None]
    if kept or not link.visuals:
        return kept
    instead = _Notes()
    return [shape for one in link.collisions if (shape := _shown(one, find, instead)) is not None]


def _shown(shape: Shape, find: FindFile, notes: _Notes) -> Shape | None:
    mesh = shape.geometry
    if not isinstance(mesh, UrdfMesh):
        return shape
    try:
        path = find(mesh.filename)
    except ModelError as error:
        notes.dropped.append(f"{mesh.filename}: {error}")
        return None
    if (unreadable := shown(path)) is not None:
        notes.dropped.append(f"{mesh.filename}: {unreadable.why}")
        return None
    return Shape(shape.link_T_shape, UrdfMesh(str(path), mesh.scale), shape.colour)


def _covered(shapes: Iterable[Shape], find: FindFile, link: str) -> tuple[list[Shape], Array]:
    """The shapes that are no meshes as they are, and capsules around the meshes together; the points of all."""
    shapes = list(shapes)
    simple = [Shape(s.link_T_shape, s.geometry) for s in shapes if not isinstance(s.geometry, UrdfMesh)]
    try:
        surfaces = [_surface(s, s.geometry, find) for s in shapes if isinstance(s.geometry, UrdfMesh)]
    except ModelError as error:
        raise ModelError(f"link {link}: {error}") from error
    capsules = covering(np.concatenate(surfaces)) if surfaces else []
    points = [NOWHERE, *(surface.reshape(-1, 3) for surface in surfaces), *map(outermost, simple)]
    return simple + [shape_of(capsule) for capsule in capsules], np.concatenate(points)


def _surface(shape: Shape, mesh: UrdfMesh, find: FindFile) -> Array:
    """The triangles of a mesh in the link's frame."""
    pose = shape.link_T_shape
    triangles: Array = read_triangles(find(mesh.filename), mesh.scale) @ pose[:3, :3].T + pose[:3, 3]
    return triangles


def _of_visuals(link: UrdfLink, find: FindFile, notes: _Notes) -> tuple[list[Shape], Array]:
    """Shapes around the visuals of a link without collision elements; none, which is said, where none can be read."""
    try:
        covered = _covered(link.visuals, find, link.name)
    except ModelError as error:
        notes.said.append(f"{link.name}: keeps no distance, since it has no collision element, and {error}")
        return [], NOWHERE
    notes.said.append(f"{link.name}: has no collision element; its visuals were covered instead")
    return covered
