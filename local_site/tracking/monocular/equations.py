"""The whole arm's normal equations from those of its links, and the step that they ask for.

Unknowns (17,): translation of the shoulder in m, turn of the upper arm in rad and change of the light on it (4), turn
of the forearm and change of the light on it (4).
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from common.geometry import Array, skew
from local_site.tracking.monocular.kernels import LIGHT, MOTION, Sums

TRANSLATION, UPPER_TURN, UPPER_LIGHT = slice(0, 3), slice(3, 6), slice(6, 10)
FOREARM_TURN, FOREARM_LIGHT = slice(10, 13), slice(13, 17)
ROOT, LOWER, ALL = slice(0, 10), slice(10, 17), slice(0, 17)
MOTIONS = np.r_[0:6, 10:13]
LIGHTS = np.r_[6:10, 13:17]
MOTIONS_BY_MOTIONS, LIGHTS_BY_LIGHTS = np.ix_(MOTIONS, MOTIONS), np.ix_(LIGHTS, LIGHTS)
MOTIONS_BY_LIGHTS = np.ix_(MOTIONS, LIGHTS)
LIGHT_SIGMA = 0.05
UNKNOWNS = 17
# What the forearm's own unknowns are of the arm's, but for what the upper arm's turn does to its joint.
FOREARM_TAKES = np.zeros((MOTION + LIGHT, UNKNOWNS))
FOREARM_TAKES[0:3, TRANSLATION] = np.eye(3)
FOREARM_TAKES[3:10, 10:17] = np.eye(7)


@dataclass(frozen=True, slots=True)
class Equations:
    """Normal matrix (17, 17) and right side (17,), and what the points say of themselves.

    `points`, `mean_square` in grey², `scaled` by its variance, and the share `near` within three sigma, each by link;
    `total` is the mean square over all points, grey².
    """

    matrix: Array
    right: Array
    points: Array
    mean_square: Array
    scaled: Array
    near: Array
    total: float


def combined(upper: Sums | None, forearm: Sums | None, elbow_arm: Array) -> Equations:
    """Both links' equations in the arm's unknowns; `elbow_arm` (3,) in m runs from shoulder to elbow.

    The forearm moves by the translation of its joint, which is the shoulder's and the upper arm's turn (eq. 2).
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
    """The maximum likelihood step (17,), zero where it is not free (eq. 17); not finite where it has no solution."""
    result = np.zeros(UNKNOWNS)
    _, solution, failed = lapack.dposv(equations.matrix[free, free], equations.right[free])
    result[free] = np.nan if failed else solution
    return result


def information(matrix: Array) -> Array:
    """What the equations say of the nine motions (9, 9) when the light is unknown."""
    across = matrix[MOTIONS_BY_LIGHTS]
    taken = across @ np.linalg.solve(matrix[LIGHTS_BY_LIGHTS], across.T)
    result: Array = matrix[MOTIONS_BY_MOTIONS] - taken
    return result


def condition(matrix: Array) -> float:
    """How ill-conditioned an information matrix (N, N) is, its unknowns brought to a common measure."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    return float(np.linalg.cond(matrix / np.outer(scale, scale)))
