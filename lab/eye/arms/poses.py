"""A store of poses: many bodies in many postures, as bones' turns and the points to be found; drawn once, by seed."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from io import BytesIO
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from common.atomic_file import write_atomically
from common.geometry import Array
from lab.eye.arms.bodies import random_shape, shaped_mesh
from lab.eye.arms.postures import random_posture
from lab.films.arm.arm_mesh import ArmMesh
from lab.films.arm.posing import PosedArm

POSTURES_PER_BODY = 100
PHALANX_SHARE = 0.5

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class PoseStore:
    """Poses in m, each in its own frame (the elbow at the origin, the forearm along x).

    Vertices (M, V, 3) of bodies at rest; of each pose its body (N,), its bones' rotations (N, B, 3, 3) and offsets
    (N, B, 3) from rest, and its points (N, 22, 3), the fingers' tips on the skin.
    """

    vertices: Floats
    body: NDArray[np.int32]
    rotations: Floats
    offsets: Floats
    points: Floats


def draw_poses(bodies: int, seed: int, processes: int) -> PoseStore:
    """Draw this many bodies, each in 100 postures; the same for the same seed, by however many processes."""
    seeds = np.random.SeedSequence(seed).spawn(bodies)
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        drawn = list(pool.map(_one_body, seeds, chunksize=4))
    return PoseStore(
        vertices=np.array([vertices for vertices, *_ in drawn]),
        body=np.repeat(np.arange(bodies, dtype=np.int32), POSTURES_PER_BODY),
        rotations=np.concatenate([rotations for _, rotations, _, _ in drawn]),
        offsets=np.concatenate([offsets for *_, offsets, _ in drawn]),
        points=np.concatenate([points for *_, points in drawn]),
    )


def stored_poses(path: Path, bodies: int, seed: int, processes: int) -> PoseStore:
    """Read the poses that a file has, or draw them and write it."""
    if not path.exists():
        poses = draw_poses(bodies, seed, processes)
        file = BytesIO()
        np.savez(file, **{field.name: getattr(poses, field.name) for field in fields(PoseStore)})
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, file.getvalue())
        return poses
    with np.load(path, allow_pickle=False) as data:
        return PoseStore(**{field.name: data[field.name] for field in fields(PoseStore)})


def _one_body(seed: np.random.SeedSequence) -> tuple[Floats, Floats, Floats, Floats]:
    random = np.random.default_rng(seed)
    mesh = shaped_mesh(random_shape(random))
    arm, tips = PosedArm(mesh), _tips_at_rest(mesh)
    poses = [_one_pose(random, mesh, arm, tips) for _ in range(POSTURES_PER_BODY)]
    rotations, offsets, points = (np.array(part, np.float32) for part in zip(*poses, strict=True))
    return mesh.vertices.astype(np.float32), rotations, offsets, points


def _one_pose(random: np.random.Generator, mesh: ArmMesh, arm: PosedArm, tips: Array) -> tuple[Array, Array, Array]:
    posture = random_posture(random, mesh, arm)
    rotations, offsets = arm.bones(posture.pose, posture.angles)
    points = [posture.pose.elbow, posture.pose.wrist]
    for digit in range(1, 6):
        bones = [mesh.bone(f"finger{digit}-{k}") for k in (1, 2, 3)]
        points += [rotations[bone] @ mesh.heads[bone] + offsets[bone] for bone in bones]
        points.append(rotations[bones[2]] @ tips[digit - 1] + offsets[bones[2]])
    return rotations, offsets, np.array(points)


def _tips_at_rest(mesh: ArmMesh) -> Array:
    """The outermost point (5, 3) of the skin along each digit's last phalanx, which moves with it."""
    weights, rest = np.asarray(mesh.fine @ mesh.weights), np.asarray(mesh.fine @ mesh.vertices)
    tips = []
    for digit in range(1, 6):
        bone = mesh.bone(f"finger{digit}-3")
        skin = rest[weights[:, bone] > PHALANX_SHARE]
        tips.append(skin[int(np.argmax(skin @ (mesh.tails[bone] - mesh.heads[bone])))])
    return np.array(tips)
