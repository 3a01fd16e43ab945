"""A surface covered by a few capsules: where one is much larger than the surface, it is cut in two; pure."""

from collections.abc import Iterator

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from common.geometry import Array
from farhand.arm_import.shapes.capsule import Capsule, enclosing_capsule

MOST = 3  # capsules of one surface
WORTH = 0.9  # of the volume: what a cut must leave to be made
CUTS = (0.2, 0.35, 0.5, 0.65, 0.8)  # of the extent
POINTS_OF_PLANE = 4


def covering(triangles: Array) -> list[Capsule]:
    """Capsules that together enclose all triangles (m x 3 x 3) in m, at most three."""
    pieces = [triangles]
    while len(pieces) < MOST:
        cuts = [(gain, k, cut) for k, piece in enumerate(pieces) for gain, cut in [_best_cut(piece)] if cut]
        if not cuts:
            break
        _, k, cut = max(cuts, key=lambda found: found[0])
        pieces[k : k + 1] = cut
    return [enclosing_capsule(_corners(piece)) for piece in pieces]


def _best_cut(piece: Array) -> tuple[float, tuple[Array, Array] | None]:
    """The volume (m³) that the best cut saves, and both halves; None where no cut is worth it."""
    whole = _rough(piece)
    tried = [(whole - _rough(one) - _rough(other), (one, other)) for one, other in _cuts(piece)]
    saved, halves = max(tried, key=lambda found: found[0], default=(0.0, None))
    return (saved, halves) if saved > (1.0 - WORTH) * whole else (0.0, None)


def _rough(piece: Array) -> float:
    return enclosing_capsule(_corners(piece), exactly=False).volume


def _cuts(piece: Array) -> Iterator[tuple[Array, Array]]:
    """Both halves of a piece, cut across each of its principal axes at some places."""
    points = piece.reshape(-1, 3)
    middle = points.mean(axis=0)
    for axis in np.linalg.eigh((points - middle).T @ (points - middle))[1].T:
        along = points @ axis
        for fraction in CUTS:
            place = float(along.min() + fraction * np.ptp(along))
            one, other = below(piece, axis, place), below(piece, -axis, -place)
            if len(one) and len(other):
                yield one, other


def below(triangles: Array, axis: Array, place: float) -> Array:
    """The part of triangles (m x 3 x 3) whose coordinate along a unit axis is at most `place`, as triangles."""
    heights = triangles @ axis - place
    inside = (heights <= 0.0).all(axis=1)
    parts = [triangles[inside]]
    crossed = ~inside & (heights < 0.0).any(axis=1)
    for triangle, height in zip(triangles[crossed], heights[crossed], strict=True):
        corners = _clipped(triangle, height)
        parts.append(np.array([[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]))
    return np.concatenate(parts)


def _clipped(triangle: Array, heights: Array) -> list[Array]:
    """The corners of the part of one triangle at heights not above zero."""
    corners: list[Array] = []
    for k in range(3):
        here, there = float(heights[k]), float(heights[(k + 1) % 3])
        if here <= 0.0:
            corners.append(triangle[k])
        if (here < 0.0) != (there < 0.0) and here != there:
            corners.append(triangle[k] + here / (here - there) * (triangle[(k + 1) % 3] - triangle[k]))
    return corners


def _corners(triangles: Array) -> Array:
    """The corners of the convex hull (m x 3), of a flat surface all corners."""
    points: Array = triangles.reshape(-1, 3)
    if len(points) > POINTS_OF_PLANE:
        try:
            return points[ConvexHull(points).vertices]
        except QhullError:
            return points
    return points
