"""A hand in the operator frame: where its spheres and tips are, and how they move with its state."""

import math
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.hand_model.skeleton import (
    FOREARM,
    FOREARM_SPHERE_DISTANCE,
    INDEX_TIP,
    PARAMETERS,
    SPHERES,
    THUMB_TIP,
    pose_spheres,
)

POSE = 6
STATE = POSE + PARAMETERS
DIFFERENCE = 1e-4


@dataclass(frozen=True, slots=True)
class HandPose:
    """A hand: wrist (3,) in m, rotation (3, 3) from the hand's frame to the operator's, posture (10,).

    Its state (16,) is the wrist's shift, a small turn in the operator frame, and the posture.
    """

    wrist: Array
    rotation: Array
    posture: Array


@dataclass(frozen=True, slots=True)
class Person:
    """What a fit takes for granted: size against the average hand, side, unit vector (3,) from wrist to elbow."""

    scale: float
    right_arm: bool
    to_elbow: Array


@dataclass(frozen=True, slots=True)
class Placed:
    """Spheres in the operator frame: centres (24, 3) and radii (24,) in m, their change with the state (24, 3, 16) and
    (24, 16)."""

    centres: Array
    radii: Array
    centre_jacobian: Array
    radius_jacobian: Array

    @property
    def arrays(self) -> tuple[Array, Array, Array, Array]:
        """Centres, radii and their changes."""
        return self.centres, self.radii, self.centre_jacobian, self.radius_jacobian

    def tip(self, sphere: int) -> Array:
        """The skin at the end of a finger (3,) in m, by the number of its last sphere."""
        spine = self.centres[sphere] - self.centres[sphere - 1]
        tip: Array = self.centres[sphere] + self.radii[sphere] / math.sqrt(float(spine @ spine)) * spine
        return tip

    @property
    def index(self) -> Array:
        """The index tip on the skin (3,) in m."""
        return self.tip(INDEX_TIP)

    @property
    def thumb(self) -> Array:
        """The thumb tip on the skin (3,) in m."""
        return self.tip(THUMB_TIP)


def place(pose: HandPose, person: Person) -> Placed:
    """The spheres of a hand; the posture's derivatives are differences."""
    forearm = person.scale * FOREARM_SPHERE_DISTANCE * person.to_elbow
    return Placed(*place_spheres(pose.wrist, pose.rotation, pose.posture, person.scale, person.right_arm, forearm))


@compiled
def place_spheres(
    wrist: Array, rotation: Array, posture: Array, scale: float, right_arm: bool, forearm: Array
) -> tuple[Array, Array, Array, Array]:
    """The arrays of `Placed`; `forearm` (3,) in m leads from the wrist to the spheres on the forearm."""
    local, radii = pose_spheres(posture, scale, right_arm)
    centres, moving, growing = np.empty((SPHERES, 3)), np.zeros((SPHERES, 3, STATE)), np.zeros((SPHERES, STATE))
    for s in range(SPHERES):
        x, y, z = _rotated(rotation, local[s])
        centres[s] = wrist[0] + x, wrist[1] + y, wrist[2] + z
        moving[s, 0, 0] = moving[s, 1, 1] = moving[s, 2, 2] = 1.0
        moving[s, 0, 4], moving[s, 0, 5] = z, -y
        moving[s, 1, 3], moving[s, 1, 5] = -z, x
        moving[s, 2, 3], moving[s, 2, 4] = y, -x
    centres[FOREARM:] += forearm
    for p in range(PARAMETERS):
        changed = posture.copy()
        changed[p] += DIFFERENCE
        other, other_radii = pose_spheres(changed, scale, right_arm)
        for s in range(SPHERES):
            x, y, z = _rotated(rotation, (other[s] - local[s]) / DIFFERENCE)
            moving[s, 0, POSE + p], moving[s, 1, POSE + p], moving[s, 2, POSE + p] = x, y, z
            growing[s, POSE + p] = (other_radii[s] - radii[s]) / DIFFERENCE
    return centres, radii, moving, growing


@compiled
def _rotated(rotation: Array, v: Array) -> tuple[float, float, float]:
    r = rotation
    return (
        r[0, 0] * v[0] + r[0, 1] * v[1] + r[0, 2] * v[2],
        r[1, 0] * v[0] + r[1, 1] * v[1] + r[1, 2] * v[2],
        r[2, 0] * v[0] + r[2, 1] * v[1] + r[2, 2] * v[2],
    )


@compiled
def turned(vector: Array) -> Array:
    """The rotation (3, 3) by a vector (3,), its length the angle in rad."""
    angle = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    if angle < 1e-9:
        return np.eye(3)
    x, y, z = vector / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result: Array = np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * (k @ k)
    return result


@compiled
def rotation_vector(rotation: Array) -> Array:
    """The vector (3,) of a rotation (3, 3) by less than half a turn."""
    r = rotation
    v = 0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    sine = math.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    cosine = 0.5 * (r[0, 0] + r[1, 1] + r[2, 2] - 1)
    return v * (math.atan2(sine, cosine) / sine) if sine > 1e-9 else v
