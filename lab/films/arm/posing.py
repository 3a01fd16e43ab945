"""The arm's mesh in a pose: bones turned, skin blended between them, and the points of the truth."""

import numpy as np

from common.geometry import Array, rotation_from_vector
from lab.films.arm.arm_mesh import ArmMesh
from local_site.simulation.body import OPEN_ABOVE, ArmTruth, BodyPose

PHALANX_SHARE = 0.5  # of a vertex's weights, by which it belongs to the last phalanx
THUMB = 1
FOREARM_TWISTS = (0.35, 0.8)  # which part of the hand's turn each half of the forearm follows


class PosedArm:
    """A mesh that takes poses of shoulder, elbow, hand and fingers."""

    def __init__(self, mesh: ArmMesh) -> None:
        self._mesh = mesh
        self._rest_hand = mesh.hand_at_rest()
        shoulder, elbow, wrist = (mesh.heads[mesh.bone(name)] for name in ("upperarm01", "lowerarm01", "wrist"))
        self._hinge = _unit(np.cross(wrist - elbow, elbow - shoulder))
        self._rest_upper = _frame(elbow - shoulder, self._hinge)
        self._rest_forearm = _frame(wrist - elbow, self._hinge)
        self._hinges = [[_hinge(mesh, digit, k) for k in range(3)] for digit in range(1, 6)]
        weights = mesh.fine @ mesh.weights
        self._phalanges = {
            name: np.flatnonzero(weights[:, mesh.bone(f"finger{k}-3")] > PHALANX_SHARE)
            for name, k in (("thumb", 1), ("index", 2))
        }

    def vertices(self, pose: BodyPose, angles: Array) -> Array:
        """The drawn surface's vertices (F, 3) in m in the operator frame; finger angles (5, 4) in rad."""
        rotations, offsets = self.bones(pose, angles)
        mesh = self._mesh
        turned = np.einsum("bij,vj->vbi", rotations, mesh.vertices) + offsets
        coarse = np.einsum("vb,vbi->vi", mesh.weights, turned)
        return np.asarray(mesh.fine @ coarse, dtype=np.float64)

    def neutral_hand(self, pose: BodyPose) -> Array:
        """Compute the hand's axes (3, 3) that go on straight from the forearm of a skeleton, turned as at rest."""
        along = pose.wrist - pose.elbow
        hinge = _unit(np.cross(along, pose.elbow - pose.shoulder))
        return np.asarray(_frame(along, hinge) @ self._rest_forearm.T @ self._rest_hand, dtype=np.float64)

    def truth(self, pose: BodyPose, angles: Array, vertices: Array) -> ArmTruth:
        """Joint centres, and the outermost vertices along the last phalanges, of a surface in this pose."""
        rotations, _ = self.bones(pose, angles)
        index, thumb = (self._tip(name, rotations, vertices) for name in ("index", "thumb"))
        return ArmTruth(pose.elbow, pose.wrist, index, thumb, pose.openness > OPEN_ABOVE)

    def _tip(self, name: str, rotations: Array, vertices: Array) -> Array:
        mesh, skin = self._mesh, vertices[self._phalanges[name]]
        bone = mesh.bone(f"finger{1 if name == 'thumb' else 2}-3")
        along = rotations[bone] @ (mesh.tails[bone] - mesh.heads[bone])
        tip: Array = skin[int(np.argmax(skin @ along))]
        return tip

    def bones(self, pose: BodyPose, angles: Array) -> tuple[Array, Array]:
        """Compute of each bone the rotation (B, 3, 3) and offset (B, 3) in m from rest into the operator frame."""
        mesh = self._mesh
        rotations, offsets = np.empty((len(mesh.bones), 3, 3)), np.empty((len(mesh.bones), 3))
        along = pose.wrist - pose.elbow
        hinge = _unit(np.cross(along, pose.elbow - pose.shoulder))
        upper = _frame(pose.elbow - pose.shoulder, hinge) @ self._rest_upper.T
        forearm = _frame(along, hinge) @ self._rest_forearm.T
        hand = pose.operator_R_hand @ self._rest_hand.T
        twist = _twist(along, forearm @ self._rest_hand[:, 1], pose.operator_R_hand[:, 1])
        first, second = (rotation_from_vector(share * twist * _unit(along)) @ forearm for share in FOREARM_TWISTS)
        anchors = {"upperarm01": ("lowerarm01", pose.elbow, upper), "upperarm02": ("lowerarm01", pose.elbow, upper)}
        anchors |= {"lowerarm01": ("lowerarm01", pose.elbow, first), "lowerarm02": ("wrist", pose.wrist, second)}
        for k, name in enumerate(mesh.bones):
            joint, at, rotation = anchors.get(name, ("wrist", pose.wrist, hand))
            rotations[k], offsets[k] = rotation, at - rotation @ mesh.heads[mesh.bone(joint)]
        for digit, (*flexions, aside) in enumerate(angles.tolist(), start=1):
            self._bend(digit, flexions, aside, rotations, offsets)
        return rotations, offsets

    def _bend(self, digit: int, flexions: list[float], aside: float, rotations: Array, offsets: Array) -> None:
        """Turn the three phalanges of a digit about their joints, each after those before it."""
        mesh = self._mesh
        bones = [mesh.bone(f"finger{digit}-{k}") for k in (1, 2, 3)]
        turn = np.eye(3)
        at = rotations[bones[0]] @ mesh.heads[bones[0]] + offsets[bones[0]]
        hand = rotations[bones[0]].copy()
        for k, bone in enumerate(bones):
            turn = turn @ self._joint(digit, k, flexions[k], aside)
            rotations[bone] = hand @ turn
            offsets[bone] = at - rotations[bone] @ mesh.heads[bone]
            if k < 2:
                at = rotations[bone] @ mesh.heads[bones[k + 1]] + offsets[bone]

    def _joint(self, digit: int, k: int, flexion: float, aside: float) -> Array:
        """The rotation (3, 3) of one joint in the mesh's frame at rest."""
        bend = rotation_from_vector(flexion * self._hinges[digit - 1][k])
        if k:
            return bend
        spread = rotation_from_vector(aside * self._rest_hand[:, 2])
        return bend @ spread if digit == THUMB else spread @ bend


def _hinge(mesh: ArmMesh, digit: int, k: int) -> Array:
    """The unit axis of a joint at rest: a finger's bends to the palm, the thumb's first turns it before the palm."""
    x, _, z = mesh.hand_at_rest().T
    if digit == THUMB and k == 0:
        return np.asarray(-x, dtype=np.float64)
    first, bone, last = (mesh.bone(f"finger{digit}-{n}") for n in (1, k + 1, 3))
    along, start, end = (mesh.tails[b] - mesh.heads[b] for b in (bone, first, last))
    return _unit(np.cross(start, end) if digit == THUMB else np.cross(_unit(along), -z))


def _twist(axis: Array, one: Array, other: Array) -> float:
    """The angle in rad about an axis from one direction to another, between -120 and 240 degrees."""
    direction = _unit(axis)
    flat = [v - (v @ direction) * direction for v in (one, other)]
    return float(np.arctan2(np.cross(flat[0], flat[1]) @ direction, flat[0] @ flat[1]))


def _frame(along: Array, hinge: Array) -> Array:
    x = _unit(along)
    z = _unit(hinge - (hinge @ x) * x)
    return np.column_stack([x, np.cross(z, x), z])


def _unit(v: Array) -> Array:
    unit: Array = v / np.linalg.norm(v)
    return unit
