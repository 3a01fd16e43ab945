"""A marker's pose from its corners in calibrated views: all views fitted together, and how certain that is; pure."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.optimize import least_squares

from common.geometry import Array, angle_between, rotation_from_vector, transform

CORNER_SIGMA_PX = 0.2  # of a real camera: noise, and what is left of its lens
CLOSE = 1e-6  # relative change of cost or pose at which a fit ends
OTHER_RAD = math.radians(5.0)  # poses that differ by less are the same minimum
AT_LEAST_TWICE = 2.0  # any other pose must fit this many times as badly, else the best is ambiguous


@dataclass(frozen=True, slots=True)
class MarkerView:
    """A marker in one view: its corners (4, 2) in pixels, and the projection (3 x 4) from the base's frame in m."""

    name: str
    projection: Array
    corners: Array

    @property
    def centre(self) -> Array:
        """The camera's position (3,), m in the base's frame."""
        return np.asarray(-np.linalg.solve(self.projection[:, :3], self.projection[:, 3]), dtype=float)


@dataclass(frozen=True, slots=True)
class MarkerPose:
    """The best pose `base_T_marker` (4 x 4); its corners, projected, miss the seen ones by `rms_px`.

    `covariance` (6 x 6) is of its position in m and of a rotation vector in rad, both in the base's axes.
    `ambiguous`: another pose fits nearly as well.
    """

    base_T_marker: Array
    rms_px: float
    covariance: Array
    ambiguous: bool

    def incidence_rad(self, view: MarkerView) -> float:
        """Compute the angle between the marker's normal and the direction to a view's camera; half a pi is edge-on."""
        way = view.centre - self.base_T_marker[:3, 3]
        return math.acos(max(-1.0, min(1.0, float(self.base_T_marker[:3, 2] @ way) / math.hypot(*way))))

    def sigma_at(self, marker_p: Array) -> tuple[float, float]:
        """Return the standard deviations of a point (3,) in the marker's frame, m, and of the orientation, rad.

        Each is that in its worst direction.
        """
        x, y, z = self.base_T_marker[:3, :3] @ marker_p
        # A step (shift, turn) moves the point r = (x, y, z) by shift + turn x r = [I, -[r]x] (shift, turn).
        lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        moves = np.hstack([np.eye(3), lever])
        position, rotation = moves @ self.covariance @ moves.T, self.covariance[3:, 3:]
        return math.sqrt(np.linalg.eigvalsh(position)[-1]), math.sqrt(np.linalg.eigvalsh(rotation)[-1])


def fit_marker(views: Sequence[MarkerView], size_m: float) -> MarkerPose | None:
    """Fit the pose of a marker with sides of `size_m` to one or more views.

    None where in no pose that was found every camera sees the marker's printed face.
    """
    square = square_corners(size_m)
    starts = _from_one(views[0], square) if len(views) == 1 else _from_several(views, square)
    fits = sorted((_refined(start, views, square) for start in starts), key=lambda fit: fit.rms_px)
    fits = [fit for fit in fits if _in_front(fit, views)]
    if not fits:
        return None
    best, *others = fits
    level = AT_LEAST_TWICE * max(best.rms_px, CORNER_SIGMA_PX)
    rivals = [other for other in others if angle_between(*_rotations(best, other)) > OTHER_RAD]
    ambiguous = any(rival.rms_px < level for rival in rivals)
    return MarkerPose(best.base_T_marker, best.rms_px, best.covariance, ambiguous)


def square_corners(size_m: float) -> Array:
    """Return the corners (4, 3) in the marker's frame, clockwise from its upper left, m."""
    half = size_m / 2
    return np.array([(-half, half, 0.0), (half, half, 0.0), (half, -half, 0.0), (-half, -half, 0.0)])


def _rotations(one: MarkerPose, other: MarkerPose) -> tuple[Array, Array]:
    return one.base_T_marker[:3, :3], other.base_T_marker[:3, :3]


def _in_front(fit: MarkerPose, views: Sequence[MarkerView]) -> bool:
    """Return whether every camera has the marker in front of it, and its printed face towards it."""
    point = np.append(fit.base_T_marker[:3, 3], 1.0)
    return all(fit.incidence_rad(v) < math.pi / 2 and v.projection[2] @ point > 0 for v in views)


def _refined(start: Array, views: Sequence[MarkerView], square: Array) -> MarkerPose:
    """Descend from `start` to the pose that fits best in its neighbourhood."""

    def moved(step: Array) -> Array:
        return transform(rotation_from_vector(step[3:]) @ start[:3, :3], start[:3, 3] + step[:3])

    def misses(step: Array) -> Array:
        points = np.column_stack([square, np.ones(4)]) @ moved(step).T
        seen = [points @ view.projection.T for view in views]
        return np.concatenate(
            [(pixels[:, :2] / pixels[:, 2:] - view.corners).ravel() for pixels, view in zip(seen, views, strict=True)]
        )

    result = least_squares(misses, np.zeros(6), method="lm", x_scale=[0.01] * 3 + [0.1] * 3, ftol=CLOSE, xtol=CLOSE)
    jacobian = np.asarray(result.jac, dtype=float)
    # The step solves J step = misses in least squares, so errors of one sigma have the covariance sigma^2 (J^T J)^-1.
    covariance = CORNER_SIGMA_PX**2 * np.linalg.pinv(jacobian.T @ jacobian)
    return MarkerPose(moved(result.x), math.sqrt(float(np.mean(result.fun**2))), covariance, ambiguous=False)


def _from_one(view: MarkerView, square: Array) -> list[Array]:
    """Both poses in which one view may see a square (Collins and Bartoli: infinitesimal plane-based pose)."""
    camera, rotation, *_ = cv2.decomposeProjectionMatrix(view.projection)
    camera = camera / camera[2, 2]
    _, turns, shifts, _ = cv2.solvePnPGeneric(square, view.corners, camera, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
    poses = []
    for turn, shift in zip(turns, shifts, strict=True):
        base_R_camera = rotation.T
        position = view.centre + base_R_camera @ shift.ravel()
        camera_R_marker = rotation_from_vector(np.asarray(turn, dtype=float).ravel())
        poses.append(transform(base_R_camera @ camera_R_marker, position))
    return poses


def _from_several(views: Sequence[MarkerView], square: Array) -> list[Array]:
    """The pose of the triangulated corners, and the one that is mirrored about the direction of the views."""
    corners = np.array([_triangulated(views, k) for k in range(4)])
    middle = corners.mean(axis=0)
    # Kabsch: the rotation nearest to the correlation of seen and true corners; the flip avoids a reflection.
    left, _, right = np.linalg.svd((corners - middle).T @ square)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    rotation = left @ flip @ right
    ways = [view.centre - middle for view in views]
    towards = np.sum([way / math.hypot(*way) for way in ways], axis=0)
    towards /= math.hypot(*towards)
    # From afar a plane looks like its mirror image about the direction of view: the normal passes to the other side of
    # that direction, by twice the angle between them.
    about = np.cross(rotation[:, 2], towards)
    turn = 2.0 * math.atan2(math.hypot(*about), float(rotation[:, 2] @ towards))
    axis = about / max(math.hypot(*about), 1e-9)
    mirrored = rotation_from_vector(turn * axis) @ rotation
    return [transform(rotation, middle), transform(mirrored, middle)]


def _triangulated(views: Sequence[MarkerView], corner: int) -> Array:
    """Compute the point (3,) in m that the views' pixels of a corner meet best, algebraically."""
    rows = []
    for view in views:
        u, v = view.corners[corner]
        p = view.projection
        # u = p[0] X / p[2] X for the homogeneous point X, so (u p[2] - p[0]) X = 0; likewise for v.
        rows += [u * p[2] - p[0], v * p[2] - p[1]]
    scaled = np.array([row / np.linalg.norm(row[:3]) for row in rows])
    x, y, z, w = np.linalg.svd(scaled)[2][-1]
    return np.asarray(np.array([x, y, z]) / w, dtype=float)
