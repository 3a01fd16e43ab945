"""The geometry of an arm and a spherical wrist in canonical angles, positive about +z and +y."""

import math
from typing import NamedTuple

Point = tuple[float, float, float]
Matrix = tuple[Point, Point, Point]
TURN = 2 * math.pi


class Target(NamedTuple):
    """Where the tool centre point shall be, and how the wrist shall be turned, in the base frame."""

    tcp: Point
    rotation: Matrix


class ArmSolution(NamedTuple):
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


def in_forearm(rotation: Matrix, arm_angles: Point) -> Matrix:
    """A rotation in the base frame as seen from the forearm: Ry(-lean) Rz(-yaw) R."""
    yaw, lean = arm_angles[0], arm_angles[1] + arm_angles[2]
    cy, sy, cl, sl = math.cos(yaw), math.sin(yaw), math.cos(lean), math.sin(lean)
    (a, b, c), (d, e, f), (g, h, i) = rotation
    u, v, w = cy * a + sy * d, cy * b + sy * e, cy * c + sy * f
    return (
        (cl * u - sl * g, cl * v - sl * h, cl * w - sl * i),
        (cy * d - sy * a, cy * e - sy * b, cy * f - sy * c),
        (sl * u + cl * g, sl * v + cl * h, sl * w + cl * i),
    )


def pitch_and_twist(m: Matrix, roll: float) -> tuple[float, float]:
    """Joints 5 and 6 that best make up the rotation Rz(roll) Ry(pitch) Rz(twist), given the roll."""
    c, s = math.cos(roll), math.sin(roll)
    (mxx, mxy, mxz), (myx, myy, myz), (mzx, mzy, mzz) = m
    pitch = math.atan2(c * mxz + s * myz, mzz)
    cp, sp = math.cos(pitch), math.sin(pitch)
    xx = cp * (c * mxx + s * myx) - sp * mzx
    xy = cp * (c * mxy + s * myy) - sp * mzy
    yx, yy = c * myx - s * mxx, c * myy - s * mxy
    return pitch, math.atan2(yx - xy, xx + yy)
