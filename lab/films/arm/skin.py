"""The skin's colours: tones from light to dark, and the colour of every vertex of an arm."""

import numpy as np

from common.geometry import Array
from lab.films.arm.arm_mesh import ArmMesh
from lab.films.picture.light import linear, vertex_normals
from local_site.simulation.room.config import SkinName
from local_site.simulation.room.surface import TONES as SHADED
from local_site.simulation.room.surface import Colour

# sRGB of evenly lit skin on the back of the hand.
TONES: dict[SkinName, Colour] = {"light": SHADED["light"].back, "medium": (184, 130, 96), "dark": (108, 72, 52)}
PALM_TOWARDS = np.array([1.06, 0.99, 0.97])  # palms are lighter and redder
KNUCKLE_TOWARDS = np.array([1.0, 0.90, 0.88])
NAIL_TOWARDS = np.array([1.08, 1.02, 1.03])
PALM_LIGHTER = {"light": 1.0, "medium": 1.18, "dark": 1.7}
MOTTLE = 0.05
SLEEVE_SHARE = 0.45  # of the upper arm, from the shoulder, that the sleeve covers


def arm_albedo(mesh: ArmMesh, tone: SkinName, sleeve_srgb: tuple[int, int, int], seed: int) -> Array:
    """The albedo (F, 3), linear BGR, of the drawn vertices: skin, palm, knuckles, nails, and a short sleeve."""
    random = np.random.default_rng(seed)
    rest = np.asarray(mesh.fine @ mesh.vertices)
    weights = np.asarray(mesh.fine @ mesh.weights)
    outward = vertex_normals(rest, mesh.triangles)
    colour = np.tile(linear(np.array(TONES[tone])), (len(rest), 1))
    dorsal = outward @ mesh.hand_at_rest()[:, 2]
    of_hand = weights[:, mesh.bone("wrist") :].sum(axis=1)
    palm = of_hand * np.clip(0.2 - 0.9 * dorsal, 0.0, 1.0)
    colour *= 1.0 + palm[:, None] * (PALM_TOWARDS * PALM_LIGHTER[tone] - 1.0)
    for name, head in zip(mesh.bones, mesh.heads, strict=True):
        if name.startswith("finger") and not name.endswith("1"):
            near = np.exp(-np.sum((rest - head) ** 2, axis=1) / 0.009**2)
            colour *= 1.0 + 0.8 * near[:, None] * (KNUCKLE_TOWARDS - 1.0)
    colour *= 1.0 + (nail_share(mesh, rest, outward, weights)[:, None]) * (NAIL_TOWARDS * 1.15 - 1.0)
    colour *= 1.0 + MOTTLE * random.standard_normal((len(rest), 1)) * (0.6, 1.0, 1.0)
    colour[along_upper_arm(mesh, rest) < SLEEVE_SHARE] = linear(np.array(sleeve_srgb))
    return colour[:, ::-1].copy()


def along_upper_arm(mesh: ArmMesh, rest: Array) -> Array:
    """Compute where points (N, 3) at rest lie along the upper arm: 0 at the shoulder, 1 at the elbow and beyond it."""
    shoulder, elbow = mesh.heads[mesh.bone("upperarm01")], mesh.heads[mesh.bone("lowerarm01")]
    along: Array = (rest - shoulder) @ (elbow - shoulder) / np.sum((elbow - shoulder) ** 2)
    return np.minimum(along, 1.0)


def nail_share(mesh: ArmMesh, rest: Array, outward: Array, weights: Array) -> Array:
    """Compute how much each vertex (F,) is nail: on the back of the last phalanges, towards their end."""
    nails, dorsal = np.zeros(len(rest)), mesh.hand_at_rest()[:, 2]
    for digit in range(1, 6):
        bone = mesh.bone(f"finger{digit}-3")
        along = mesh.tails[bone] - mesh.heads[bone]
        length = float(np.linalg.norm(along))
        back = dorsal - (dorsal @ along) * along / length**2
        at = (rest - mesh.heads[bone]) @ along / length**2
        facing = outward @ back / np.linalg.norm(back)
        nails += (weights[:, bone] > 0.5) * np.clip(8.0 * (at - 0.42), 0, 1) * np.clip(4.0 * (facing - 0.62), 0, 1)
    return nails
