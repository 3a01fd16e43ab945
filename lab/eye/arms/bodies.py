"""Bodies of every build: the mesh's three shapes blended beyond themselves, its bones lengthened, its limbs thickened."""

from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array
from lab.films.arm.arm_mesh import ArmMesh, load_arm_mesh

FOREARM_M = (0.195, 0.315)  # every length as often as another, and independent of girth: no mean is to be learned
UPPER_ARM_M = (0.20, 0.34)
GIRTH = (0.82, 1.28)
HAND_SCALE = (0.82, 1.16)
FINGER_LENGTH, HAND_BREADTH = (0.88, 1.14), (0.88, 1.14)
BLEND_REACH = 1.5  # how far beyond the mesh's own shapes a blend may go


@dataclass(frozen=True, slots=True)
class BodyShape:
    """What a body is made of: weights (3,) of the mesh's shapes, lengths in m, and factors of girth and hand."""

    blend: Array
    forearm_m: float
    upper_arm_m: float
    forearm_girth: float
    upper_arm_girth: float
    hand_scale: float
    finger_length: float
    hand_breadth: float


def random_shape(random: np.random.Generator) -> BodyShape:
    """Draw a body from infant-slim to muscular, each measure by itself."""
    blend = np.full(3, 1.0 / 3.0) + BLEND_REACH * (random.dirichlet(np.full(3, 0.6)) - 1.0 / 3.0)
    girth = random.uniform(*GIRTH)
    return BodyShape(
        blend=blend,
        forearm_m=random.uniform(*FOREARM_M),
        upper_arm_m=random.uniform(*UPPER_ARM_M),
        forearm_girth=girth * random.uniform(0.93, 1.07),
        upper_arm_girth=girth * random.uniform(0.93, 1.07),
        hand_scale=random.uniform(*HAND_SCALE),
        finger_length=random.uniform(*FINGER_LENGTH),
        hand_breadth=random.uniform(*HAND_BREADTH),
    )


def shaped_mesh(shape: BodyShape) -> ArmMesh:
    """Make the mesh of a body: each bone's part is stretched about the joint that it hangs from, skin is blended."""
    meshes = [load_arm_mesh(body) for body in ("average", "thin", "muscular")]
    blended = replace(
        meshes[0],
        vertices=_blend(shape.blend, [mesh.vertices for mesh in meshes]),
        heads=_blend(shape.blend, [mesh.heads for mesh in meshes]),
        tails=_blend(shape.blend, [mesh.tails for mesh in meshes]),
    )
    stretches, offsets = _stretches(blended, shape)
    moved = np.einsum("bij,vj->vbi", stretches, blended.vertices) + offsets
    return replace(
        blended,
        vertices=np.einsum("vb,vbi->vi", blended.weights, moved),
        heads=np.einsum("bij,bj->bi", stretches, blended.heads) + offsets,
        tails=np.einsum("bij,bj->bi", stretches, blended.tails) + offsets,
    )


def _blend(weights: Array, parts: list[Array]) -> Array:
    return np.asarray(np.tensordot(weights, np.array(parts), axes=1), dtype=np.float64)


def _stretches(mesh: ArmMesh, shape: BodyShape) -> tuple[Array, Array]:
    """Of each bone the stretch (B, 3, 3) and the offset (B, 3): x becomes stretch x + offset; the elbow stays."""
    elbow, wrist = mesh.heads[mesh.bone("lowerarm01")], mesh.heads[mesh.bone("wrist")]
    shoulder = mesh.heads[mesh.bone("upperarm01")]
    forearm = _along(wrist - elbow, shape.forearm_m / mesh.forearm_m, shape.forearm_girth)
    upper = _along(elbow - shoulder, shape.upper_arm_m / mesh.upper_arm_m, shape.upper_arm_girth)
    new_wrist = elbow + forearm @ (wrist - elbow)
    axes = mesh.hand_at_rest()
    hand = shape.hand_scale * axes @ np.diag([1.0, shape.hand_breadth, 0.5 + 0.5 * shape.hand_breadth]) @ axes.T
    stretches, offsets = np.empty((len(mesh.bones), 3, 3)), np.empty((len(mesh.bones), 3))
    for k, name in enumerate(mesh.bones):
        if name.startswith("upperarm"):
            stretches[k], offsets[k] = upper, elbow - upper @ elbow
        elif name.startswith("lowerarm"):
            stretches[k], offsets[k] = forearm, elbow - forearm @ elbow
        else:
            stretches[k], offsets[k] = hand, new_wrist - hand @ wrist
    for digit in range(1, 6):
        _stretch_finger(mesh, digit, shape, hand, stretches, offsets)
    return stretches, offsets


def _stretch_finger(
    mesh: ArmMesh, digit: int, shape: BodyShape, hand: Array, stretches: Array, offsets: Array
) -> None:
    """Lengthen a finger about its knuckle, on top of what the hand's own stretch does to it."""
    first, last = mesh.bone(f"finger{digit}-1"), mesh.bone(f"finger{digit}-3")
    knuckle = mesh.heads[first]
    finger = hand @ _along(mesh.tails[last] - knuckle, shape.finger_length, 1.0)
    at = hand @ knuckle + offsets[first]
    for k in (1, 2, 3):
        bone = mesh.bone(f"finger{digit}-{k}")
        stretches[bone], offsets[bone] = finger, at - finger @ knuckle


def _along(direction: Array, along: float, across: float) -> Array:
    """The stretch (3, 3) by one factor along a direction and by another across it."""
    axis = direction / np.linalg.norm(direction)
    stretch: Array = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    return stretch
