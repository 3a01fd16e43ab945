"""The meshes that an arm is written with, as files of one folder beside it; pure."""

from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path, PurePath

from common.text import MOST_OF_NAME, file_name
from farhand.arm_import.description.elements import Shape, UrdfLink, UrdfMesh, UrdfRobot


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
