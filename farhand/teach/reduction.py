"""A path reduced to way points: every pose of it stays within a tolerance of the straight way between them; pure."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from common.geometry import Array


def reduced(poses: Array, keep: Sequence[int], tolerance_m: float, tolerance_rad: float) -> list[int]:
    """The indices of the poses (n, 4, 4) that are left, the ends and those to `keep` among them.

    Between two of them the position goes straight, the orientation turns about one axis, both in proportion to the way
    that the path has come; Ramer-Douglas-Peucker on both distances, each as a part of its tolerance.
    """
    fixed = sorted({0, len(poses) - 1, *keep})
    way = _way(poses, tolerance_m, tolerance_rad)
    left = set(fixed)
    waiting = list(pairwise(fixed))
    while waiting:
        begin, end = waiting.pop()
        if end - begin < 2:
            continue
        apart = _apart(poses[begin : end + 1], way[begin : end + 1], tolerance_m, tolerance_rad)
        worst = begin + int(np.argmax(apart))
        if apart[worst - begin] > 1.0:
            left.add(worst)
            waiting += [(begin, worst), (worst, end)]
    return sorted(left)


def _way(poses: Array, tolerance_m: float, tolerance_rad: float) -> Array:
    """How far the path has come at each pose, in tolerances."""
    moved = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / tolerance_m
    orientations = Rotation.from_matrix(poses[:, :3, :3])
    turned = (orientations[:-1].inv() * orientations[1:]).magnitude() / tolerance_rad
    return np.concatenate([[0.0], np.cumsum(moved + turned)])


def _apart(poses: Array, way: Array, tolerance_m: float, tolerance_rad: float) -> Array:
    """How far each pose is from the straight way between the first and the last, in tolerances."""
    length = way[-1] - way[0]
    part = (way - way[0]) / length if length > 0.0 else np.zeros(len(way))
    straight = poses[0, :3, 3] + part[:, None] * (poses[-1, :3, 3] - poses[0, :3, 3])
    off_m = np.linalg.norm(poses[:, :3, 3] - straight, axis=1)
    orientations = Rotation.from_matrix(poses[:, :3, :3])
    turn = (orientations[0].inv() * orientations[-1]).as_rotvec()
    off_rad = ((orientations[0] * Rotation.from_rotvec(part[:, None] * turn)).inv() * orientations).magnitude()
    apart: Array = np.maximum(off_m / tolerance_m, off_rad / tolerance_rad)
    return apart
