"""The mesh of a bare right arm: its vertices, bones and weights, and the finer surface that is drawn."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from common.geometry import Array
from lab.films.arm.subdivision import subdivided

MESH = Path(__file__).parent / "arm_mesh.npz"  # MakeHuman's, in the public domain: see arm_mesh.LICENSE.md
MM = 1e-3

Body = Literal["average", "thin", "muscular"]
FINGERS = {"thumb": 1, "index": 2, "middle": 3, "ring": 4, "little": 5}


@dataclass(frozen=True, slots=True)
class ArmMesh:
    """An arm at rest, in m in the mesh's own frame.

    Coarse vertices (V, 3) move with bones by weights (V, B); `fine` (F, V) makes the vertices of the drawn surface of
    them, whose triangles (T, 3) are seen from outside anticlockwise. Bones have a name, a head and a tail (B, 3).
    """

    vertices: Array
    weights: Array
    fine: csr_array
    triangles: NDArray[np.int32]
    bones: tuple[str, ...]
    heads: Array
    tails: Array

    def bone(self, name: str) -> int:
        """The number of a bone."""
        return self.bones.index(name)

    @property
    def upper_arm_m(self) -> float:
        """From the shoulder's to the elbow's centre."""
        return float(np.linalg.norm(self.heads[self.bone("lowerarm01")] - self.heads[self.bone("upperarm01")]))

    @property
    def forearm_m(self) -> float:
        """From the elbow's to the wrist's centre."""
        return float(np.linalg.norm(self.heads[self.bone("wrist")] - self.heads[self.bone("lowerarm01")]))

    def hand_at_rest(self) -> Array:
        """The hand's frame at rest (3, 3) as columns: x distal, y radial, z dorsal."""
        index, middle, little = (self.heads[self.bone(f"finger{k}-1")] for k in (2, 3, 5))
        distal = middle - self.heads[self.bone("wrist")]
        x = distal / np.linalg.norm(distal)
        radial = (index - little) - ((index - little) @ x) * x
        y = radial / np.linalg.norm(radial)
        return np.column_stack([x, y, np.cross(x, y)])


@lru_cache(maxsize=3)  # as many as there are bodies
def load_arm_mesh(body: Body) -> ArmMesh:
    """Read the mesh of a body, once: it is made finer and shared, nobody changes it.

    The file has quads, weights, bones, and verts, head and tail of each body in mm.
    """
    with np.load(MESH, allow_pickle=False) as data:
        quads = np.asarray(data["quads"], np.int32)
        vertices = MM * np.asarray(data[f"verts_{body}"], float)
        fine, fine_quads = subdivided(quads, len(vertices))
        return ArmMesh(
            vertices=vertices,
            weights=np.asarray(data["weights"], float),
            fine=fine,
            triangles=np.vstack([fine_quads[:, [0, 1, 2]], fine_quads[:, [0, 2, 3]]]),
            bones=tuple(str(name).removesuffix(".R") for name in data["bones"]),
            heads=MM * np.asarray(data[f"head_{body}"], float),
            tails=MM * np.asarray(data[f"tail_{body}"], float),
        )
