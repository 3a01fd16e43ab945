"""Meshes as triangles, and which of them MuJoCo can show."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import coal
import numpy as np

from common.errors import ModelError
from common.geometry import Array
from remote_site.kinematics.meshes import words_of

SHOWN = (".stl", ".obj")  # formats that MuJoCo decodes
MOST_SHOWN = 200_000  # triangles of an STL file that MuJoCo takes
STL_HEAD, STL_TRIANGLE = 84, 50  # bytes


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Why a mesh cannot be used."""

    why: str


def read_triangles(path: Path, scale: Sequence[float]) -> Array:
    """The triangles (m x 3 x 3) of a mesh in m in its own axes; ModelError where it cannot be read."""
    try:
        mesh = coal.MeshLoader().load(str(path), np.array(scale, dtype=float))
        vertices = np.array(mesh.vertices(), dtype=float)
        corners = np.array([[t[0], t[1], t[2]] for t in map(mesh.tri_indices, range(mesh.num_tris))], dtype=int)
    except (ValueError, RuntimeError, OSError) as error:
        said = words_of(error)
        raise ModelError(f"the mesh {path} cannot be read: {said}; give it as STL, OBJ or Collada") from error
    if not len(corners) or not np.isfinite(vertices).all():
        raise ModelError(f"the mesh {path} has no surface; give it as STL, OBJ or Collada")
    triangles: Array = vertices[corners]
    return triangles


def shown(path: Path) -> Unreadable | None:
    """None where MuJoCo can show the mesh, else why not."""
    if path.suffix.lower() not in SHOWN:
        return Unreadable(f"MuJoCo reads {' and '.join(SHOWN)}, not {path.suffix or 'a file without an ending'}")
    if path.suffix.lower() == ".stl" and not 0 < _triangles_of_stl(path) <= MOST_SHOWN:
        return Unreadable(f"it is no binary STL file of at most {MOST_SHOWN} triangles")
    return None


def _triangles_of_stl(path: Path) -> int:
    """Return how many triangles a binary STL file has; 0 where it is none."""
    with path.open("rb") as file:
        head = file.read(STL_HEAD)
    count = int.from_bytes(head[80:], "little") if len(head) == STL_HEAD else 0
    return count if path.stat().st_size >= STL_HEAD + count * STL_TRIANGLE else 0
