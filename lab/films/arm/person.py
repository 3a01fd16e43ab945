"""A filmed person: a posed arm of the mesh in skin and sleeve, of either side, and a simple torso with a head."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from lab.films.arm.arm_mesh import ArmMesh
from lab.films.arm.motions import ArmMotion
from lab.films.arm.posing import PosedArm
from lab.films.arm.postures import PostureName, posture_angles
from lab.films.arm.skin import TONES, along_upper_arm, arm_albedo
from lab.films.film import HandTruth
from lab.films.picture.light import linear
from local_site.kernels.rasterising import Triangles
from local_site.simulation.body import ArmTruth
from local_site.simulation.room.config import SkinName

MIRROR_X = 0.53  # a left arm is a right one mirrored in the plane x = MIRROR_X
RINGS, SPOKES = 18, 28
BEGINS_AT = 0.06  # of the upper arm: what the mesh has before is the rim of a cut
# Middle from the shoulder and half axes, in m: the torso stands between shoulder and cameras, seen from its side.
TORSO = (np.array([0.09, -0.17, -0.42]), np.array([0.12, 0.20, 0.53]))
HEAD = (np.array([0.06, -0.17, 0.27]), np.array([0.095, 0.075, 0.125]))
SHOULDER = (np.array([-0.015, -0.015, -0.015]), np.array([0.084, 0.082, 0.078]))
NECK = (np.array([0.08, -0.17, 0.12]), np.array([0.055, 0.055, 0.12]))


@dataclass(frozen=True, slots=True)
class ColouredSurface:
    """A surface: vertices (V, 3) in m in the operator frame, triangles (T, 3), albedo (V, 3), linear BGR."""

    vertices: Array
    triangles: Triangles
    albedo: Array


@dataclass(frozen=True, slots=True)
class FilmedPerson:
    """One person's arm: what it does, in which posture, skin, sleeve, and which side; times in s of the motion.

    `offset` (3,) in m moves the whole person.
    """

    mesh: ArmMesh
    motion: ArmMotion
    posture: PostureName
    tone: SkinName
    sleeve_srgb: tuple[int, int, int]
    right: bool = True
    offset: Array = field(default_factory=lambda: np.zeros(3))
    seed: int = 1

    def filming(self) -> "PersonInMotion":
        """The same person, ready to be filmed."""
        return PersonInMotion(self)


class PersonInMotion:
    """The surfaces and the truth of a person by time."""

    def __init__(self, person: FilmedPerson) -> None:
        self._person = person
        self._arm = PosedArm(person.mesh)
        self._albedo = arm_albedo(person.mesh, person.tone, person.sleeve_srgb, person.seed)
        self._closed, self._open = posture_angles(person.posture), posture_angles("open")
        self._triangles = _handed(person.mesh.triangles[_beyond_shoulder(person.mesh)], person.right)
        cloth = linear(np.array(person.sleeve_srgb))
        body = body_of(person.motion.pose(0.0).shoulder, cloth, person.tone)
        self._body = replace(body, triangles=_handed(body.triangles, person.right))

    def arm(self, t_s: float, offset: Array) -> ColouredSurface:
        """The arm's surface, moved by an offset (3,) in m."""
        vertices = self._vertices(t_s)
        return ColouredSurface(self._placed(vertices) + offset, self._triangles, self._albedo)

    def body(self, offset: Array) -> ColouredSurface:
        """Torso, neck and head."""
        return replace(self._body, vertices=self._placed(self._body.vertices) + offset)

    def truth(self, t_s: float, offset: Array) -> HandTruth:
        """Compute what is to be found of the arm, moved by an offset (3,) in m."""
        person = self._person
        pose = person.motion.pose(t_s)
        found = self._arm.truth(pose, self._angles(pose.openness), self._vertices(t_s))
        joints = np.array([found.elbow, found.wrist, found.index, found.thumb])
        elbow, wrist, index, thumb = self._placed(joints) + offset
        rotation = pose.operator_R_hand
        if not person.right:
            rotation = np.diag([-1.0, 1.0, 1.0]) @ rotation @ np.diag([1.0, -1.0, 1.0])
        name = "open" if found.hand_open else person.posture
        return HandTruth(ArmTruth(elbow, wrist, index, thumb, found.hand_open), rotation, person.right, name)

    def _vertices(self, t_s: float) -> Array:
        pose = self._person.motion.pose(t_s)
        return self._arm.vertices(pose, self._angles(pose.openness))

    def _angles(self, openness: float) -> Array:
        return (1.0 - openness) * self._closed + openness * self._open

    def _placed(self, points: Array) -> Array:
        if self._person.right:
            return points + self._person.offset
        mirrored: Array = points * (-1.0, 1.0, 1.0) + np.array([2.0 * MIRROR_X, 0.0, 0.0])
        return mirrored + self._person.offset


def _handed(triangles: Triangles, right: bool) -> Triangles:
    """Triangles that are seen from outside, also on a mirrored surface."""
    return np.ascontiguousarray(triangles if right else triangles[:, ::-1])


def _beyond_shoulder(mesh: ArmMesh) -> NDArray[np.bool_]:
    """Which triangles (T,) lie beyond the shoulder, of which the mesh has only a rim."""
    at = np.asarray(mesh.fine @ along_upper_arm(mesh, mesh.vertices))
    kept: NDArray[np.bool_] = at[mesh.triangles].min(axis=1) > BEGINS_AT
    return kept


def body_of(shoulder: Array, cloth: Array, tone: SkinName) -> ColouredSurface:
    """Torso, neck and head of a person whose right shoulder is at (3,) in m; `cloth` (3,) is linear RGB."""
    skin = linear(np.array(TONES[tone]))
    surfaces = [
        ellipsoid(shoulder + NECK[0], NECK[1], skin),
        ellipsoid(shoulder + TORSO[0], TORSO[1], cloth),
        ellipsoid(shoulder + SHOULDER[0], SHOULDER[1], cloth),
        _head(shoulder + HEAD[0], skin),
    ]
    counts = np.cumsum([0, *(len(s.vertices) for s in surfaces)])
    return ColouredSurface(
        np.vstack([s.vertices for s in surfaces]),
        np.vstack([s.triangles + n for s, n in zip(surfaces, counts, strict=False)]).astype(np.int32),
        np.vstack([s.albedo for s in surfaces]),
    )


def ellipsoid(middle: Array, axes: Array, rgb: Array) -> ColouredSurface:
    """An ellipsoid along the axes of the operator frame, with half axes (3,) in m, of one linear colour."""
    tilt, turn = np.meshgrid(np.linspace(0.0, np.pi, RINGS), np.linspace(0.0, 2.0 * np.pi, SPOKES), indexing="ij")
    unit = np.dstack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)]).reshape(-1, 3)
    at = np.arange(RINGS * SPOKES).reshape(RINGS, SPOKES)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    triangles = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])]).astype(np.int32)
    return ColouredSurface(middle + axes * unit, triangles, np.tile(rgb[::-1], (len(unit), 1)))


def _head(middle: Array, skin: Array) -> ColouredSurface:
    """A head that looks along -x, with hair, eyes and a mouth."""
    head = ellipsoid(middle, HEAD[1], skin)
    x, y, z = ((head.vertices - middle) / HEAD[1]).T
    hair = (z > 0.55) | ((x > 0.1) & (z > -0.35))
    eyes = (x < 0) & (np.abs(np.abs(y) - 0.42) < 0.16) & (np.abs(z - 0.18) < 0.10)
    mouth = (x < 0) & (np.abs(y) < 0.35) & (np.abs(z + 0.5) < 0.08)
    head.albedo[hair | eyes] = 0.03
    head.albedo[mouth] *= (0.5, 0.5, 0.85)
    return head
