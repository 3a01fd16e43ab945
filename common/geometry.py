"""Rigid transforms and rotations as NumPy arrays; quaternions are (x, y, z, w) everywhere.

`a_T_b` is a 4 x 4 matrix that takes coordinates in frame b to frame a; `a_R_b` its 3 x 3 rotation.
"""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIN_LENGTH = 1e-9


def transform(rotation: Array, translation: Array) -> Array:
    """A 4 x 4 rigid transform from a 3 x 3 rotation and a translation (3,) in m."""
    result = np.eye(4)
    result[:3, :3] = rotation
    result[:3, 3] = translation
    return result


def inverse(a_T_b: Array) -> Array:
    """The inverse `b_T_a` of a rigid transform."""
    rotation_t = a_T_b[:3, :3].T
    return transform(rotation_t, -rotation_t @ a_T_b[:3, 3])


def quaternion_from_rotation(rotation: Array) -> Array:
    """The unit quaternion (x, y, z, w), w >= 0, of a 3 x 3 rotation (Shepperd's method)."""
    m = rotation
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    squares = np.array([m[0, 0], m[1, 1], m[2, 2], trace])
    k = int(np.argmax(squares))
    q = np.empty(4)
    if k == 3:
        q[:] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1.0 + trace
    else:
        i, j, n = k, (k + 1) % 3, (k + 2) % 3
        q[i] = 1.0 + m[i, i] - m[j, j] - m[n, n]
        q[j] = m[j, i] + m[i, j]
        q[n] = m[n, i] + m[i, n]
        q[3] = m[n, j] - m[j, n]
    q /= math.sqrt(float(q @ q))
    return -q if q[3] < 0 else q


def rotation_from_quaternion(quaternion: Array) -> Array:
    """The 3 x 3 rotation of a quaternion (x, y, z, w) of any length but zero."""
    x, y, z, w = quaternion / math.sqrt(float(quaternion @ quaternion))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotation_from_vector(rotation_vector: Array) -> Array:
    """The 3 x 3 rotation about a vector (3,) by its length in rad (Rodrigues)."""
    angle = math.sqrt(float(rotation_vector @ rotation_vector))
    if angle < MIN_LENGTH:
        return np.eye(3) + skew(rotation_vector)
    k = skew(rotation_vector / angle)
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * (k @ k)


def vector_from_rotation(rotation: Array) -> Array:
    """The rotation vector (3,) in rad, of length at most pi, of a 3 x 3 rotation."""
    x, y, z, w = quaternion_from_rotation(rotation)
    axis = np.array([x, y, z])
    sine = math.sqrt(float(axis @ axis))
    if sine < MIN_LENGTH:
        return 2.0 * axis
    return axis * (2.0 * math.atan2(sine, w) / sine)


def unwound(vector: Array, last: Array) -> Array:
    """The rotation vector (3,) in rad of the same rotation, a whole turn more or less, that is nearest to the last."""
    angle = math.sqrt(float(vector @ vector))
    if angle < 1.0:
        return vector
    other: Array = vector * (1.0 - 2 * math.pi / angle)
    near, far = vector - last, other - last
    return other if float(far @ far) < float(near @ near) else vector


def skew(v: Array) -> Array:
    """The 3 x 3 matrix of the cross product with v."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def hand_rotation(wrist: Array, index: Array, thumb: Array) -> Array | None:
    """The orientation `operator_R_hand` (3 x 3) of the hand from its three points in m.

    x runs from the wrist to the middle between the two tips (c' of thesis section 4.2), z along the normal
    of the plane wrist-index-thumb, (index - wrist) x (thumb - wrist), and y completes the frame. None when the points
    are collinear within `MIN_LENGTH`, so that no orientation exists.
    """
    to_index, to_thumb = index - wrist, thumb - wrist
    x = 0.5 * (to_index + to_thumb)
    z = skew(to_index) @ to_thumb
    x_length, z_length = math.sqrt(float(x @ x)), math.sqrt(float(z @ z))
    if x_length < MIN_LENGTH or z_length < MIN_LENGTH:
        return None
    x, z = x / x_length, z / z_length
    return np.column_stack([x, skew(z) @ x, z])
