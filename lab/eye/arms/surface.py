"""The skin as points: samples of the mesh's triangles, close enough to leave no hole, and what each point is."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from common.geometry import Array
from lab.films.arm.arm_mesh import ArmMesh, load_arm_mesh
from lab.films.arm.skin import along_upper_arm, nail_share
from lab.films.picture.light import vertex_normals

CropKind = Literal["arm", "hand", "whole"]
# How many samples per cm² of skin, on the hand and elsewhere: some six for each pixel that a point falls on.
DENSITY_PER_CM2: dict[CropKind, tuple[float, float]] = {"arm": (220.0, 170.0), "hand": (900.0, 550.0), "whole": (80.0, 65.0)}
SEEN_BEYOND: dict[CropKind, float] = {"arm": 0.2, "hand": 1.2, "whole": 0.2}  # along the arm: what lies before is not drawn
CM2 = 1e-4
GOLDEN = np.array([0.7548776662466927, 0.5698402909980532])  # of the R2 sequence, which fills a triangle evenly
NOISES = 12
NOISE_WIDTHS = 4  # from single vertices to some 130 of them


@dataclass(frozen=True, slots=True)
class SkinPoints:
    """Samples of the surface: the triangle (P,) that each lies in and where (P, 3), barycentric."""

    triangle: Array
    barycentric: Array


@dataclass(frozen=True, slots=True)
class SkinAttributes:
    """What each drawn vertex is, the same on every body.

    `along` (F,) is 0 at the shoulder, 1 at the elbow, 2 at the wrist, 3 at the middle finger's tip; `around` (F,) the
    angle about the limb in rad; `digit` (F,) 0 on the palm, 1 to 5; `along_digit` (F,) 0 to 3 over its phalanges;
    `palm`, `nail`, `knuckle` (F,) 0 to 1; `noises` (F, 12), smooth over the skin, mean 0, deviation 1.
    """

    along: Array
    around: Array
    digit: Array
    along_digit: Array
    palm: Array
    nail: Array
    knuckle: Array
    noises: Array


@lru_cache(maxsize=1)
def skin_attributes() -> SkinAttributes:
    """Compute the attributes of the average body's drawn vertices, once."""
    mesh = load_arm_mesh("average")
    rest = np.asarray(mesh.fine @ mesh.vertices)
    weights = np.asarray(mesh.fine @ mesh.weights)
    outward = vertex_normals(rest, mesh.triangles)
    digit, along_digit = _digits(mesh, rest, weights)
    of_hand = weights[:, mesh.bone("wrist") :].sum(axis=1)
    knuckles = [mesh.heads[mesh.bone(f"finger{d}-{k}")] for d in range(1, 6) for k in (2, 3)]
    near = cKDTree(np.array(knuckles)).query(rest)[0]
    return SkinAttributes(
        along=_along(mesh, rest),
        around=_around(mesh, rest),
        digit=digit,
        along_digit=along_digit,
        palm=of_hand * np.clip(0.2 - 0.9 * outward @ mesh.hand_at_rest()[:, 2], 0.0, 1.0),
        nail=nail_share(mesh, rest, outward, weights),
        knuckle=np.exp(-((near / 0.009) ** 2)),
        noises=_noises(rest),
    )


@lru_cache(maxsize=3)  # as many as there are kinds
def skin_points(kind: CropKind) -> SkinPoints:
    """Spread samples over the triangles of the average body, by their area, evenly in each."""
    mesh = load_arm_mesh("average")
    rest = np.asarray(mesh.fine @ mesh.vertices)
    a, b, c = (rest[mesh.triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    along = _along(mesh, rest)[mesh.triangles].mean(axis=1)
    on_hand, elsewhere = DENSITY_PER_CM2[kind]
    counts = np.maximum(np.ceil(area / CM2 * np.where(along > 1.95, on_hand, elsewhere)), 3).astype(np.int64)
    counts[along < SEEN_BEYOND[kind]] = 0
    triangle = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(triangle)) - np.repeat(np.cumsum(counts) - counts, counts)
    u, v = np.modf(0.5 + number[:, None] * GOLDEN)[0].T
    folded = u + v > 1.0
    u, v = np.where(folded, 1.0 - u, u), np.where(folded, 1.0 - v, v)
    return SkinPoints(triangle, np.column_stack([1.0 - u - v, u, v]))


def _along(mesh: ArmMesh, rest: Array) -> Array:
    elbow, wrist = mesh.heads[mesh.bone("lowerarm01")], mesh.heads[mesh.bone("wrist")]
    tip = mesh.tails[mesh.bone("finger3-3")]
    forearm = np.clip((rest - elbow) @ (wrist - elbow) / np.sum((wrist - elbow) ** 2), 0.0, 1.0)
    hand = np.clip((rest - wrist) @ (tip - wrist) / np.sum((tip - wrist) ** 2), 0.0, 1.2)
    return np.minimum(along_upper_arm(mesh, rest), 1.0) + forearm + hand


def _around(mesh: ArmMesh, rest: Array) -> Array:
    """The angle (F,) about the line from shoulder to wrist at rest, where the arm is nearly straight."""
    shoulder, wrist = mesh.heads[mesh.bone("upperarm01")], mesh.heads[mesh.bone("wrist")]
    axis = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    side = np.cross(axis, mesh.hand_at_rest()[:, 2])
    elbow = mesh.heads[mesh.bone("lowerarm01")]
    off = rest - np.where((_along(mesh, rest) < 1.0)[:, None], 0.5 * (shoulder + elbow), 0.5 * (elbow + wrist))
    return np.asarray(np.arctan2(off @ side, off @ np.cross(axis, side)))


def _digits(mesh: ArmMesh, rest: Array, weights: Array) -> tuple[Array, Array]:
    digit, along = np.zeros(len(rest)), np.zeros(len(rest))
    for d in range(1, 6):
        bones = [mesh.bone(f"finger{d}-{k}") for k in (1, 2, 3)]
        mine = weights[:, bones].sum(axis=1) > 0.5
        for k, bone in enumerate(bones):
            axis = mesh.tails[bone] - mesh.heads[bone]
            at = np.clip((rest - mesh.heads[bone]) @ axis / (axis @ axis), 0.0, 1.0)
            along = np.where(mine & (at > 0.0), k + at, along)
        digit = np.where(mine, d, digit)
    return digit, along


def _noises(rest: Array) -> Array:
    """Smooth random fields (F, 12) on the skin: white noise, averaged over neighbours within several distances."""
    random, tree = np.random.default_rng(0), cKDTree(rest)
    fields = []
    for k in range(NOISES):
        near = tree.query(rest, k=1 + int(4 ** (k % NOISE_WIDTHS) * 2))[1].reshape(len(rest), -1)
        field = random.standard_normal(len(rest))[near].mean(axis=1)
        fields.append((field - field.mean()) / field.std())
    return np.array(fields).T
