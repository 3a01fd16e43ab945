"""The geometry of an arm and a spherical wrist in canonical angles, positive about +z and +y."""

import math
from typing import NamedTuple

Point = tuple[float, float, float]
Rows = list[list[float]]
TURN = 2 * math.pi


class Target(NamedTuple):
    """Where the tool centre point shall be, and how the wrist shall be turned, in the base frame."""

    tcp: Point
    rotation: Rows


class Arm(NamedTuple):
    """A solution for joints 1 to 3 in the canonical angles, positive about +z and +y."""

    angles: Point
    shoulder: int
    elbow: int
    held: bool


def apart(q: list[float], current: tuple[float, ...]) -> float:
    """The squared distance in joint space, of as many joints as there are."""
    return sum((a - b) ** 2 for a, b in zip(q, current, strict=False))


def minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def in_forearm(rotation: Rows, arm_angles: Point) -> Rows:
    """A rotation in the base frame as seen from the forearm: Ry(-lean) Rz(-yaw) R."""
    yaw, lean = arm_angles[0], arm_angles[1] + arm_angles[2]
    cy, sy, cl, sl = math.cos(yaw), math.sin(yaw), math.cos(lean), math.sin(lean)
    first, second, third = rotation[0][:3], rotation[1][:3], rotation[2][:3]
    ahead = [cy * a + sy * b for a, b in zip(first, second, strict=True)]
    return [
        [cl * a - sl * c for a, c in zip(ahead, third, strict=True)],
        [cy * b - sy * a for a, b in zip(first, second, strict=True)],
        [sl * a + cl * c for a, c in zip(ahead, third, strict=True)],
    ]


def pitch_and_twist(m: Rows, roll: float) -> tuple[float, float]:
    """Joints 5 and 6 that best make up the rotation Rz(roll) Ry(pitch) Rz(twist), given the roll."""
    c, s = math.cos(roll), math.sin(roll)
    pitch = math.atan2(c * m[0][2] + s * m[1][2], m[2][2])
    cp, sp = math.cos(pitch), math.sin(pitch)
    xx = cp * (c * m[0][0] + s * m[1][0]) - sp * m[2][0]
    xy = cp * (c * m[0][1] + s * m[1][1]) - sp * m[2][1]
    yx, yy = c * m[1][0] - s * m[0][0], c * m[1][1] - s * m[0][1]
    return pitch, math.atan2(yx - xy, xx + yy)
