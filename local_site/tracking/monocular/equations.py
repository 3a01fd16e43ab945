"""The arm's normal equations from intensity errors at observation points, summed for each link, and their solution.

Unknowns (17,): translation of the shoulder in m, rotation of the upper arm in rad and change of the light on it (4),
rotation of the forearm in rad and change of the light on it (4).
The report's equation 12 with its errata: the errors go by -dI/dB, the third term has the depth squared, and the
rotation about z is gx ry - gy rx.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from common.geometry import Array, skew
from local_site.kernels.compiled import compiled
from local_site.kernels.pictures import level_at
from local_site.tracking.monocular.picture import PyramidLevel

MOTION, LIGHT = 6, 4
LINK_UNKNOWNS = MOTION + LIGHT

TRANSLATION, UPPER_TURN, UPPER_LIGHT = slice(0, 3), slice(3, 6), slice(6, 10)
FOREARM_TURN, FOREARM_LIGHT = slice(10, 13), slice(13, 17)
ROOT, LOWER, ALL = slice(0, 10), slice(10, 17), slice(0, 17)
MOTIONS = np.r_[0:6, 10:13]
LIGHTS = np.r_[6:10, 13:17]
MOTIONS_BY_MOTIONS, LIGHTS_BY_LIGHTS = np.ix_(MOTIONS, MOTIONS), np.ix_(LIGHTS, LIGHTS)
MOTIONS_BY_LIGHTS = np.ix_(MOTIONS, LIGHTS)
LIGHT_SIGMA = 0.05
UNKNOWNS = 17
# The forearm's unknowns in terms of the arm's, but for the effect of the upper arm's rotation on its joint.
FOREARM_TAKES = np.zeros((LINK_UNKNOWNS, UNKNOWNS))
FOREARM_TAKES[0:3, TRANSLATION] = np.eye(3)
FOREARM_TAKES[3:10, 10:17] = np.eye(7)

Sums = tuple[Array, Array, Array]


class Surface(NamedTuple):
    """Observation points (N, 3) in m and normals (N, 3) in the link's frame, reflectances (N,) in grey levels."""

    points: Array
    normals: Array
    reflectances: Array


@compiled
def fill_observation(row: Array, gradient: Array, focal: Array, point: Array, arm: Array) -> None:
    """The derivative of the negative intensity error by the link's motion: translation in m, rotation in rad (eq. 12).

    Fills the first six of `row`. `gradient` (2,) is the picture's per px, `focal` (2,) in px, `point` (3,) in the
    camera's frame in m, and `arm` (3,) the vector from the joint to the point.
    """
    x, y, z = point[0], point[1], point[2]
    rx, ry, rz = arm[0], arm[1], arm[2]
    gx, gy = gradient[0] * focal[0], gradient[1] * focal[1]
    near = 1.0 / z
    radial = (gx * x + gy * y) * near
    row[0], row[1], row[2] = -gx * near, -gy * near, radial * near
    row[3] = (radial * ry + gy * rz) * near
    row[4] = -(radial * rx + gx * rz) * near
    row[5] = (gx * ry - gy * rx) * near


@compiled
def rotate(result: Array, rotation: Array, vector: Array) -> None:
    """The vector (3,) rotated, into `result`; a matrix product would allocate an array for each point."""
    for k in range(3):
        result[k] = rotation[k, 0] * vector[0] + rotation[k, 1] * vector[1] + rotation[k, 2] * vector[2]


@compiled
def _add_point(matrix: Array, right: Array, row: Array, weight: float, error: float) -> None:
    """Add one point to the normal equations, in the upper half of the matrix."""
    for i in range(LINK_UNKNOWNS):
        weighted = weight * row[i]
        right[i] += weighted * error
        for j in range(i, LINK_UNKNOWNS):
            matrix[i, j] += weighted * row[j]


@compiled
def _huber(deviation: float, huber: float) -> tuple[float, float]:
    """Huber's weight and clipped square of a deviation in standard deviations."""
    if deviation <= huber:
        return 1.0, deviation * deviation
    return huber / deviation, huber * (2.0 * deviation - huber)


@compiled
def _fill_light(row: Array, reflectance: float, normal: Array, light: Array) -> float:
    """Fill the last four of `row`: how the intensity error changes with the light; return the light at the point."""
    row[MOTION], lit = reflectance, light[0]
    for k in range(3):
        row[MOTION + 1 + k] = reflectance * normal[k]
        lit += light[1 + k] * normal[k]
    return float(lit)


@compiled
def summed(
    surface: Surface, link: tuple[Array, Array, Array], level: PyramidLevel, variances: Array, huber: float
) -> Sums:
    """Normal matrix (10, 10), right side (10,) and statistics (4,) of a link's observation points.

    `link`: its joint (3,) in m, its rotation (3, 3) and the light (4,) on it. `variances`: camera noise in grey² and
    position error (3,) in m² (section 2.3). Unknowns: motion (6,), then the change of the light. Statistics: how many
    points lie inside the picture, their mean squared error in grey², clipped after Huber, the same divided by its
    variance, the fraction within three sigma.
    """
    points, normals, reflectances = surface
    joint, rotation, light = link
    picture, along_x, along_y, focal, principal = level
    height, width = picture.shape
    matrix, right = np.zeros((LINK_UNKNOWNS, LINK_UNKNOWNS)), np.zeros(LINK_UNKNOWNS)
    row, gradient, point = np.empty(LINK_UNKNOWNS), np.empty(2), np.empty(3)
    arm, normal = np.empty(3), np.empty(3)
    seen, squares, scaled, near = 0, 0.0, 0.0, 0
    for n in range(len(points)):
        rotate(arm, rotation, points[n])
        for k in range(3):
            point[k] = joint[k] + arm[k]
        u = focal[0] * point[0] / point[2] + principal[0]
        v = focal[1] * point[1] / point[2] + principal[1]
        if not (point[2] > 0.0 and 0.0 <= u < width - 1 and 0.0 <= v < height - 1):
            continue
        gradient[0], gradient[1] = level_at(along_x, u, v), level_at(along_y, u, v)
        fill_observation(row, gradient, focal, point, arm)
        rotate(normal, rotation, normals[n])
        lit, variance = _fill_light(row, reflectances[n], normal, light), variances[0]
        for k in range(3):
            variance += row[k] * row[k] * variances[1 + k]
        error = level_at(picture, u, v) - lit * reflectances[n]
        deviation = abs(error) / math.sqrt(variance)
        weight, clipped = _huber(deviation, huber)
        _add_point(matrix, right, row, weight / variance, error)
        seen, near = seen + 1, near + (deviation <= 3.0)
        squares, scaled = squares + clipped * variance, scaled + clipped
    matrix += np.triu(matrix, 1).T
    count = max(seen, 1)
    return matrix, right, np.array([seen, squares / count, scaled / count, near / count])


@dataclass(frozen=True, slots=True)
class Equations:
    """Normal matrix (17, 17) and right side (17,), and the points' statistics.

    The number of `points`, `mean_square` in grey², `scaled` by its variance, and the fraction `near` within three
    sigma, each by link; `total` is the mean square over all points, grey².
    """

    matrix: Array
    right: Array
    points: Array
    mean_square: Array
    scaled: Array
    near: Array
    total: float


def combined(upper: Sums | None, forearm: Sums | None, elbow_arm: Array) -> Equations:
    """Both links' equations in the arm's unknowns; `elbow_arm` (3,) in m is the vector from shoulder to elbow.

    The translation of the forearm's joint follows from the shoulder's and the upper arm's rotation (eq. 2).
    """
    matrix, right, statistics = np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS), np.zeros((2, 4))
    matrix[LIGHTS, LIGHTS] = 1.0 / LIGHT_SIGMA**2
    if upper is not None:
        matrix[:10, :10] += upper[0]
        right[:10] += upper[1]
        statistics[0] = upper[2]
    if forearm is not None:
        takes = FOREARM_TAKES.copy()
        takes[0:3, UPPER_TURN] = -skew(elbow_arm)
        matrix += takes.T @ forearm[0] @ takes
        right += takes.T @ forearm[1]
        statistics[1] = forearm[2]
    points, mean_square, scaled, near = statistics.T
    total = float(points @ mean_square) / max(float(points.sum()), 1.0)
    return Equations(matrix, right, points, mean_square, scaled, near, total)


def step(equations: Equations, free: slice) -> Array:
    """The maximum likelihood step (17,), zero where it is not free (eq. 17); NaN where it has no solution."""
    result = np.zeros(UNKNOWNS)
    _, solution, failed = lapack.dposv(equations.matrix[free, free], equations.right[free])
    result[free] = np.nan if failed else solution
    return result


def information(matrix: Array) -> Array:
    """The information (9, 9) about the nine motions with the light marginalised out: a Schur complement."""
    cross = matrix[MOTIONS_BY_LIGHTS]
    result: Array = matrix[MOTIONS_BY_MOTIONS] - cross @ np.linalg.solve(matrix[LIGHTS_BY_LIGHTS], cross.T)
    return result


def condition(matrix: Array) -> float:
    """The condition number of an information matrix (N, N) whose unknowns are scaled to a unit diagonal."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    return float(np.linalg.cond(matrix / np.outer(scale, scale)))
