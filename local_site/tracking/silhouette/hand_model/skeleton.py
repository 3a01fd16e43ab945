"""The hand as spheres joined to tapered capsules: the sizes of a grown hand, and the spheres' positions and Jacobians.

Local frame: origin at the wrist's centre of rotation, x to the knuckle of the middle finger, y to the thumb's side,
z out of the back of the hand. Lengths of metacarpals and phalanges are the averages of grown hands; all else scales
with them.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled

MCP_CURL, PIP_CURL, EXTRA_CURL, SPREAD, ABDUCTION, OPPOSITION, THUMB_FLEXION, PALM, FINGERS, BREADTH = range(10)
PARAMETERS = 10
TYPICAL_FOREARM = 0.28
DIP_PER_PIP = 0.7

_KNUCKLES = np.array([[0.113, 0.030, 0.0], [0.116, 0.005, 0.002], [0.110, -0.017, 0.0], [0.100, -0.037, -0.005]])
_PHALANGES = np.array(
    [[0.0398, 0.0224, 0.0197], [0.0446, 0.0263, 0.0213], [0.0414, 0.0257, 0.0212], [0.0327, 0.0181, 0.0197]]
)
_FINGER_RADII = np.array(
    [
        [0.0125, 0.0095, 0.0082, 0.0065],
        [0.0130, 0.0098, 0.0084, 0.0067],
        [0.0125, 0.0092, 0.0080, 0.0064],
        [0.0115, 0.0082, 0.0070, 0.0057],
    ]
)
_SPREAD_OF = np.array([0.5, -0.3, -0.9, -1.6])
_REST_SPREAD = np.array([0.03, 0.0, -0.03, -0.06])
_FAN = -np.diff(_SPREAD_OF)  # rad that two neighbours turn apart, by rad of spread
_REACH = np.minimum(_PHALANGES[1:].sum(axis=1), _PHALANGES[:-1].sum(axis=1))  # m, of the shorter of two neighbours
GAP_BY_SPREAD = float((_FAN * _REACH).min())  # m that the tips part least of all neighbours', by rad of spread
TIP_RADIUS = float(_FINGER_RADII[:, -1].mean())
_EXTRA_OF = np.array([0.0, 0.7, 1.0, 1.0])
_THUMB_BASE = np.array([0.036, 0.022, -0.008])
_THUMB_LENGTHS = np.array([0.0462, 0.0316, 0.0260])
_THUMB_RADII = np.array([0.0165, 0.0125, 0.0105, 0.0085])
_WRIST = np.array([[0.0, 0.011, 0.0], [0.0, -0.011, 0.0]])
_WRIST_RADIUS = 0.0185
FOREARM_SPHERE_DISTANCE = 0.06

THUMB, WRIST, FOREARM, SPHERES = 16, 20, 22, 24
INDEX_TIP, MIDDLE_KNUCKLE, MIDDLE_TIP, THUMB_TIP = 3, 4, 7, 19

_fingers = [(4 * f + j, 4 * f + j + 1) for f in range(4) for j in range(3)]
_palm = [(20, 0), (20, 4), (21, 8), (21, 12), (0, 4), (4, 8), (8, 12), (20, 21), (20, 16), (16, 0)]
_thumb = [(16, 17), (17, 18), (18, 19)]
CAPSULES: NDArray[np.intp] = np.array(_fingers + _palm + _thumb + [(20, 22), (21, 23)], dtype=np.intp)


@compiled
def pose_spheres(posture: Array, scale: float, right_arm: bool) -> tuple[Array, Array]:
    """Centres (24, 3) in the local frame and radii (24,) in m, for a posture (10,).

    The posture is angles in rad, then the logarithms of three sizes; `scale` is the person's. The forearm's spheres
    coincide with the wrist's: their distance along the forearm is not part of the hand.
    """
    centres, radii = np.empty((SPHERES, 3)), np.empty(SPHERES)
    length = scale * math.exp(posture[FINGERS])
    sizes = np.array([scale * math.exp(posture[PALM]), scale * math.exp(posture[BREADTH]), 0.0])
    sizes[2] = sizes[1]
    for finger in range(4):
        _fill_finger(centres, finger, posture, sizes, length)
        radii[4 * finger : 4 * finger + 4] = sizes[1] * _FINGER_RADII[finger]
    _fill_thumb(centres, posture, sizes, length)
    radii[THUMB : THUMB + 4] = sizes[1] * _THUMB_RADII
    for k in range(4):
        centres[WRIST + k] = sizes * _WRIST[k % 2]
        radii[WRIST + k] = sizes[1] * _WRIST_RADIUS
    if not right_arm:
        centres[:, 1] *= -1.0
    return centres, radii


def most_curled(posture: Array) -> float:
    """The curl in rad of the finger that is curled most, for a posture (10,)."""
    curl: float = posture[MCP_CURL] + posture[PIP_CURL] + 2 * max(0.0, posture[EXTRA_CURL])
    return curl


@compiled
def _fill_finger(centres: Array, finger: int, posture: Array, sizes: Array, length: float) -> None:
    """Knuckle, two joints and tip's centre."""
    turn = _REST_SPREAD[finger] + posture[SPREAD] * _SPREAD_OF[finger]
    extra = posture[EXTRA_CURL] * _EXTRA_OF[finger]
    pip = posture[PIP_CURL] + extra
    bends = (posture[MCP_CURL] + extra, pip, DIP_PER_PIP * pip)
    centres[4 * finger] = sizes * _KNUCKLES[finger]
    angle = 0.0
    for j in range(3):
        angle += bends[j]
        reach = length * _PHALANGES[finger, j]
        step = np.array([math.cos(angle) * math.cos(turn), math.cos(angle) * math.sin(turn), -math.sin(angle)])
        centres[4 * finger + j + 1] = centres[4 * finger + j] + reach * step


@compiled
def _fill_thumb(centres: Array, posture: Array, sizes: Array, length: float) -> None:
    """Base, two joints and tip's centre.

    The thumb points away from the palm's plane by the opposition, away from the index by the abduction, and bends
    towards the little finger's side.
    """
    ca, sa = math.cos(posture[ABDUCTION]), math.sin(posture[ABDUCTION])
    co, so = math.cos(posture[OPPOSITION]), math.sin(posture[OPPOSITION])
    out, inwards = np.array([ca * co, sa * co, -so]), np.array([sa, -ca, 0.0])
    centres[THUMB] = sizes * _THUMB_BASE
    for j in range(3):
        angle = j * posture[THUMB_FLEXION]
        step = math.cos(angle) * out + math.sin(angle) * inwards
        centres[THUMB + j + 1] = centres[THUMB + j] + length * _THUMB_LENGTHS[j] * step


POSE = 6
STATE = POSE + PARAMETERS
DIFFERENCE = 1e-4


class HandPose(NamedTuple):
    """A hand: wrist (3,) in m, `operator_R_hand` (3, 3), posture (10,).

    Its state (16,) is the wrist's translation, a small rotation in the operator frame, and the posture.
    """

    wrist: Array
    rotation: Array
    posture: Array


class Person(NamedTuple):
    """The givens of a fit: size relative to the average hand, side, unit vector (3,) from wrist to elbow."""

    scale: float
    right_arm: bool
    to_elbow: Array


class HandSpheres(NamedTuple):
    """Spheres in the operator frame: centres (24, 3) and radii (24,) in m, with Jacobians (24, 3, 16) and (24, 16) by
    the hand's state."""

    centres: Array
    radii: Array
    centre_jacobian: Array
    radius_jacobian: Array

    def tip(self, sphere: int) -> Array:
        """The skin at the end of a finger (3,) in m, by the number of its last sphere."""
        spine = self.centres[sphere] - self.centres[sphere - 1]
        tip: Array = self.centres[sphere] + self.radii[sphere] / math.sqrt(float(spine @ spine)) * spine
        return tip


@compiled
def hand_spheres(pose: HandPose, person: Person) -> HandSpheres:
    """The spheres of a hand; the Jacobian by the posture is a finite difference."""
    wrist, rotation, posture = pose
    local, radii = pose_spheres(posture, person.scale, person.right_arm)
    centres, moving, growing = np.empty((SPHERES, 3)), np.zeros((SPHERES, 3, STATE)), np.zeros((SPHERES, STATE))
    for s in range(SPHERES):
        x, y, z = _rotated(rotation, local[s])
        centres[s] = wrist[0] + x, wrist[1] + y, wrist[2] + z
        moving[s, 0, 0] = moving[s, 1, 1] = moving[s, 2, 2] = 1.0
        moving[s, 0, 4], moving[s, 0, 5] = z, -y
        moving[s, 1, 3], moving[s, 1, 5] = -z, x
        moving[s, 2, 3], moving[s, 2, 4] = y, -x
    centres[FOREARM:] += person.scale * FOREARM_SPHERE_DISTANCE * person.to_elbow
    for p in range(PARAMETERS):
        changed = posture.copy()
        changed[p] += DIFFERENCE
        other, other_radii = pose_spheres(changed, person.scale, person.right_arm)
        for s in range(SPHERES):
            x, y, z = _rotated(rotation, (other[s] - local[s]) / DIFFERENCE)
            moving[s, 0, POSE + p], moving[s, 1, POSE + p], moving[s, 2, POSE + p] = x, y, z
            growing[s, POSE + p] = (other_radii[s] - radii[s]) / DIFFERENCE
    return HandSpheres(centres, radii, moving, growing)


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
    """The rotation (3, 3) of a rotation vector (3,) in rad; compiled, unlike `common.geometry.rotation_from_vector`."""
    angle = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    if angle < 1e-9:
        return np.eye(3)
    x, y, z = vector / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result: Array = np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * (k @ k)
    return result


@compiled
def rotation_vector(rotation: Array) -> Array:
    """The rotation vector (3,) in rad of a rotation (3, 3) by less than pi."""
    r = rotation
    v = 0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    sine = math.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    cosine = 0.5 * (r[0, 0] + r[1, 1] + r[2, 2] - 1)
    return v * (math.atan2(sine, cosine) / sine) if sine > 1e-9 else v
