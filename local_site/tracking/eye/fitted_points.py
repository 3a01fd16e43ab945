"""The arm's points in space that fit what all views see of them, the lengths of bones, and how the arm moved; pure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.eye.arm_points import AVERAGE_M, BONES, POINTS, SPREAD

FREEDOM = 4.0  # of Student's distribution: some points are far off
ITERATIONS = 4
STIFF_M = 0.0015  # how exactly a bone keeps its length: landmarks lie on the skin too
CORRELATED = 8.0  # instants that err alike: so many tell of a length what one would
LEAST_SPREAD_M = 0.0008  # of a length, however long it was seen
LEAST_DEPTH_M = 0.05
UNKNOWN = 3 * POINTS + len(BONES)


@dataclass(frozen=True, slots=True)
class PointSight:
    """What one view sees of the points: undistorted `pixels` (22, 2), and the whitening (22, 2, 2) of their errors.

    A whitening of 0 tells nothing of a point.
    """

    projection: Array
    pixels: Array
    whitening: Array


@dataclass(frozen=True, slots=True)
class Lengths:
    """The bones' lengths (27,) in m as far as they are known, and their standard deviations (27,) in m."""

    mean_m: Array
    sigma_m: Array

    @classmethod
    def unknown(cls) -> "Lengths":
        """Those of any body."""
        return cls(AVERAGE_M.copy(), SPREAD * AVERAGE_M)

    def learned(self, mean_m: Array, sigma_m: Array) -> "Lengths":
        """Learn from one instant more, in which the lengths were `mean_m` with `sigma_m`, all that was known included.

        What the instant alone tells is the difference of informations; of that only a part counts, as instants err
        alike.
        """
        known, all_told = self.sigma_m**-2, np.minimum(sigma_m, self.sigma_m) ** -2
        information = known + (all_told - known) / CORRELATED
        mean = (known * self.mean_m + (all_told * mean_m - known * self.mean_m) / CORRELATED) / information
        return Lengths(mean, np.maximum(information**-0.5, LEAST_SPREAD_M))


@dataclass(frozen=True, slots=True)
class Expected:
    """Where the points (22, 3) in m are expected, and the standard deviation (22,) in m of that in each direction."""

    points: Array
    sigma_m: Array


@dataclass(frozen=True, slots=True)
class FittedPoints:
    """Points (22, 3) in m and their covariances (22, 3, 3) in m²; the bones' lengths in this instant (27,) with their
    deviations; and the mean of the squared whitened misses, 1 where these are as large as expected."""

    points: Array
    covariances: Array
    length_m: Array
    length_sigma_m: Array
    misfit: float


def fit_points(sights: Sequence[PointSight], expected: Expected, lengths: Lengths) -> FittedPoints:
    """Find the points that fit sights, expectation and lengths best, by Gauss-Newton with Student's weights."""
    points, length_m = expected.points.copy(), lengths.mean_m.copy()
    for _ in range(ITERATIONS):
        normal, right, _ = _equations(points, length_m, sights, expected, lengths)
        step = np.linalg.solve(normal, right)
        points, length_m = points + step[: 3 * POINTS].reshape(POINTS, 3), length_m + step[3 * POINTS :]
    normal, _, misfit = _equations(points, length_m, sights, expected, lengths)
    covariance: Array = np.asarray(np.linalg.inv(normal), dtype=np.float64)
    blocks = covariance[: 3 * POINTS, : 3 * POINTS].reshape(POINTS, 3, POINTS, 3)
    of_points: Array = blocks[np.arange(POINTS), :, np.arange(POINTS)]
    length_sigma = np.sqrt(np.diag(covariance)[3 * POINTS :])
    return FittedPoints(points, of_points, length_m, length_sigma, misfit)


def _equations(
    points: Array, length_m: Array, sights: Sequence[PointSight], expected: Expected, lengths: Lengths
) -> tuple[Array, Array, float]:
    """The normal equations (93, 93), (93,) of a step, and the misfit of the sights."""
    information = expected.sigma_m**-2
    blocks = information[:, None, None] * np.eye(3)
    gradients = information[:, None] * (expected.points - points)
    squares, count = 0.0, 0
    for sight in sights:
        off, slope = _seen_from(sight, points)
        square = np.sum(off**2, axis=1)
        weight = (FREEDOM + 2.0) / (FREEDOM + square)
        transposed = slope.transpose(0, 2, 1) * weight[:, None, None]
        blocks = blocks + transposed @ slope
        gradients = gradients + (transposed @ off[..., None])[..., 0]
        told = sight.whitening[:, 0, 0] > 0.0
        squares, count = squares + float(np.sum(np.minimum(square[told], 25.0))), count + 2 * int(told.sum())
    normal, right = np.zeros((UNKNOWN, UNKNOWN)), np.zeros(UNKNOWN)
    at = np.arange(POINTS)
    normal[: 3 * POINTS, : 3 * POINTS].reshape(POINTS, 3, POINTS, 3)[at, :, at] = blocks
    right[: 3 * POINTS] = gradients.ravel()
    _add_bones(normal, right, points, length_m, lengths)
    return normal, right, squares / max(count, 1)


def _seen_from(sight: PointSight, points: Array) -> tuple[Array, Array]:
    """The whitened misses (22, 2) of points in a view, and how they change (22, 2, 3) per m."""
    projection = sight.projection
    h = points @ projection[:, :3].T + projection[:, 3]
    depth = np.maximum(h[:, 2], LEAST_DEPTH_M)
    pixels = h[:, :2] / depth[:, None]
    jacobian = (projection[None, :2, :3] - pixels[..., None] * projection[2, :3]) / depth[:, None, None]
    off = (sight.whitening @ (sight.pixels - pixels)[..., None])[..., 0]
    return off, sight.whitening @ jacobian


def _add_bones(normal: Array, right: Array, points: Array, length_m: Array, lengths: Lengths) -> None:
    """Each bone's ends are its length apart, and that is about what was learned."""
    begin, end = BONES.T
    way = points[end] - points[begin]
    long = np.maximum(np.linalg.norm(way, axis=1), 1e-6)
    rows = np.zeros((len(BONES), UNKNOWN))
    k = np.arange(len(BONES))
    for d in range(3):
        rows[k, 3 * end + d] = way[:, d] / long
        rows[k, 3 * begin + d] = -way[:, d] / long
    rows[k, 3 * POINTS + k] = -1.0
    normal += rows.T @ rows / STIFF_M**2
    right += rows.T @ (length_m - long) / STIFF_M**2
    known = lengths.sigma_m**-2
    normal[3 * POINTS + k, 3 * POINTS + k] += known
    right[3 * POINTS + k] += known * (lengths.mean_m - length_m)
