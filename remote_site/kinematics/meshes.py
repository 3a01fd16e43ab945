"""The mesh files that a URDF names: seen from the URDF's own folder, and from nowhere else."""

from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

from common.errors import ModelError


def place_meshes(folder: Path, meshes: Iterable[ElementTree.Element]) -> None:
    """Give the <mesh> elements of a URDF in `folder` the whole paths of their files; addresses such as package://
    stay as they are."""
    for mesh in meshes:
        name = mesh.get("filename", "")
        if "://" not in name:
            mesh.set("filename", str((folder / name).absolute()))


def check_meshes(urdf: Path, meshes: Iterable[ElementTree.Element]) -> None:
    """ModelError names the first file that placed <mesh> elements lack, and the cure."""
    names = [mesh.get("filename", "") for mesh in meshes]
    missing = list(dict.fromkeys(name for name in names if "://" not in name and not Path(name).is_file()))
    if missing:
        more = f", and {len(missing) - 1} more are missing" if len(missing) > 1 else ""
        raise ModelError(
            f"{urdf} names the mesh {missing[0]}, and there is no such file{more}; bring the folder of its meshes to "
            "where the URDF is, or import the maker's URDF again: farhand arm import"
        )


def words_of(error: Exception) -> str:
    """Return what coal's loader says of a mesh, without the places in its own source and its hint."""
    said = str(error).split("message:")[-1].split("Hint:")[0]
    return " ".join(said.split())
