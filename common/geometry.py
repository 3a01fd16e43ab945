"""Rigid transforms and rotations as NumPy arrays; quaternions are (x, y, z, w) everywhere.

`a_T_b` is a 4 x 4 matrix that takes coordinates in frame b to frame a; `a_R_b` its 3 x 3 rotation.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIN_LENGTH = 1e-9
IDENTITY = np.eye(4)
LONGEST_CHORD = math.sqrt(8.0)  # between two orientations half a turn apart


def transform(rotation: Array, translation: Array) -> Array:
    """A 4 x 4 rigid transform from a 3 x 3 rotation and a translation (3,) in m."""
    result = IDENTITY.copy()
    result[:3, :3] = rotation
    result[:3, 3] = translation
    return result


def inverse(a_T_b: Array) -> Array:
    """The inverse `b_T_a` of a rigid transform."""
    rotation_t = a_T_b[:3, :3].T
    return transform(rotation_t, -rotation_t @ a_T_b[:3, 3])


def quaternion_from_rotation(rotation: Array) -> Array:
    """The unit quaternion (x, y, z, w), w >= 0, of a 3 x 3 rotation (Shepperd's method)."""
    return np.array(_quaternion(rotation))


def rotation_from_quaternion(quaternion: Sequence[float]) -> Array:
    """The 3 x 3 rotation of a quaternion (x, y, z, w), whose length rounding has changed; of zeros no rotation."""
    x, y, z, w = quaternion
    square = x * x + y * y + z * z + w * w
    s = 2 / square if square > 0 else 0.0
    return np.array(
        [
            [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
        ]
    )


def _quaternion(rotation: Array) -> tuple[float, float, float, float]:
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    trace = a + e + i
    largest = max(a, e, i, trace)
    if largest == trace:
        x, y, z, w = h - f, c - g, d - b, 1.0 + trace
    elif largest == a:
        x, y, z, w = 1.0 + a - e - i, d + b, g + c, h - f
    elif largest == e:
        x, y, z, w = b + d, 1.0 + e - a - i, h + f, c - g
    else:
        x, y, z, w = c + g, f + h, 1.0 + i - a - e, d - b
    length = math.sqrt(x * x + y * y + z * z + w * w)
    scale = -1.0 / length if w < 0 else 1.0 / length
    return x * scale, y * scale, z * scale, w * scale


def rotation_from_vector(rotation_vector: Array) -> Array:
    """The 3 x 3 rotation about a vector (3,) by its length in rad (Rodrigues)."""
    x, y, z = rotation_vector.tolist()
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < MIN_LENGTH:
        return np.array([[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]])
    x, y, z = x / angle, y / angle, z / angle
    c, s = math.cos(angle), math.sin(angle)
    u, v, w = (1 - c) * x, (1 - c) * y, (1 - c) * z
    return np.array(
        [
            [u * x + c, u * y - s * z, u * z + s * y],
            [u * y + s * z, v * y + c, v * z - s * x],
            [u * z - s * y, v * z + s * x, w * z + c],
        ]
    )


def vector_from_rotation(rotation: Array) -> Array:
    """The rotation vector (3,) in rad, of length at most pi, of a 3 x 3 rotation."""
    x, y, z, w = _quaternion(rotation)
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 if sine < MIN_LENGTH else 2.0 * math.atan2(sine, w) / sine
    return np.array([x * scale, y * scale, z * scale])


def pose_between(begin: Array, end: Array, fraction: float) -> Array:
    """The pose (4 x 4) at a fraction of the straight way between two, turned by the same fraction."""
    turn = vector_from_rotation(begin[:3, :3].T @ end[:3, :3])
    position = begin[:3, 3] + fraction * (end[:3, 3] - begin[:3, 3])
    return transform(begin[:3, :3] @ rotation_from_vector(fraction * turn), position)


def angle_between(a_R_b: Array, a_R_c: Array) -> float:
    """The angle in rad, at most pi, between two orientations (3 x 3): twice that of the chord between them."""
    chord = math.dist(a_R_b.ravel().tolist(), a_R_c.ravel().tolist())
    return 2.0 * math.asin(min(chord / LONGEST_CHORD, 1.0))


def unwound(vector: Array, last: Array) -> Array:
    """The rotation vector (3,) in rad of the same rotation that is nearest to the last: a turn more or less."""
    angle = math.sqrt(float(vector @ vector))
    if angle < 1.0:
        return vector
    other: Array = vector * (1.0 - 2 * math.pi / angle)
    near, far = vector - last, other - last
    return other if float(far @ far) < float(near @ near) else vector


def skew(v: Array) -> Array:
    """The 3 x 3 matrix of the cross product with v."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def hand_rotation(wrist: Iterable[float], index: Iterable[float], thumb: Iterable[float]) -> Array | None:
    """The orientation `operator_R_hand` (3 x 3) of the hand from its three points in m.

    x runs from the wrist to the middle between the two tips (c' of thesis section 4.2), z along the normal
    of the plane wrist-index-thumb, (index - wrist) x (thumb - wrist), and y completes the frame. None when the points
    are collinear within `MIN_LENGTH`, so that no orientation exists.
    """
    origin = tuple(wrist)
    to_index = [tip - start for tip, start in zip(index, origin, strict=True)]
    to_thumb = [tip - start for tip, start in zip(thumb, origin, strict=True)]
    ahead = [a + b for a, b in zip(to_index, to_thumb, strict=True)]
    x, z = _unit(ahead, 2 * MIN_LENGTH), _unit(_cross(to_index, to_thumb), MIN_LENGTH)
    return None if x is None or z is None else np.array([x, _cross(z, x), z]).T


def _cross(u: list[float], v: list[float]) -> list[float]:
    (a, b, c), (d, e, f) = u, v
    return [b * f - c * e, c * d - a * f, a * e - b * d]


def _unit(v: list[float], least: float) -> list[float] | None:
    x, y, z = v
    length = math.sqrt(x * x + y * y + z * z)
    return None if length < least else [x / length, y / length, z / length]
