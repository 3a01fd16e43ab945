"""The equations between elbow, wrist and what the views show of them, in standard deviations."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.compiled import compiled
from local_site.tracking.silhouette.features import Features

FOREARM_SIGMA = 0.06
UPPER_ARM_SIGMA = 0.15
NECK_SIGMA = 0.3
ROUGH_SIGMA = 3.0
EXPECTED_SIGMA = 1.0
CLEAR_BEND_SINE = 0.4
MIN_BEND_SINE = 0.02
MIN_LENGTH = 1e-6
TINY = 1e-40


@dataclass(frozen=True, slots=True)
class Link:
    """A known distance, and its standard deviation, of the elbow from an anchor (3,), None for the wrist; all in m."""

    anchor: Array | None
    length: float
    sigma: float


@dataclass(frozen=True, slots=True)
class Shifts:
    """How far beside the medial lines of a view, along their normals in px, the elbow's axis of rotation lies."""

    forearm_px: float = 0.0
    upper_arm_px: float = 0.0


@dataclass(frozen=True, slots=True)
class Constraints:
    """Image lines of one view, normals (K, 2) and offsets (K,) in standard deviations.

    The elbow lies on the first `elbows` of them, the wrist on the others.
    """

    projection: Array
    normals: Array
    offsets: Array
    elbows: int

    @property
    def arrays(self) -> tuple[Array, Array, Array, int]:
        """All of it as `descend` takes it."""
        return self.projection, self.normals, self.offsets, self.elbows


def constraints_of(projection: Array, view: Features, shifts: Shifts) -> Constraints:
    """The lines that a view lays down.

    The elbow's expected place along the forearm weighs next to nothing, except where nothing else fixes it. Where the
    arm looks nearly straight, a small offset of the upper arm's line would move the meeting point far along the arm.
    """
    forearm, root = view.forearm, view.root
    neck = NECK_SIGMA if view.wrist is not None else ROUGH_SIGMA
    lines = [
        (root.normal, root.at(0.0) + shifts.forearm_px * root.normal, FOREARM_SIGMA),
        (forearm.direction, view.guess.elbow, EXPECTED_SIGMA),
        (forearm.normal, forearm.point, FOREARM_SIGMA),
        (forearm.direction, view.guess.wrist, neck),
    ]
    if view.upper_arm is not None:
        upper = view.upper_arm
        bend = max(abs(float(upper.normal @ forearm.direction)), MIN_BEND_SINE)
        sigma = UPPER_ARM_SIGMA * max(1.0, CLEAR_BEND_SINE / bend) ** 2
        lines.insert(0, (upper.normal, upper.point + shifts.upper_arm_px * upper.normal, sigma))
    normals = np.array([normal / (sigma * view.half_width) for normal, _, sigma in lines])
    points = np.array([point for _, point, _ in lines])
    return Constraints(projection, normals, np.sum(normals * points, axis=1), len(lines) - 2)


def known_distances(links: Sequence[Link]) -> Array:
    """The links as rows (N, 5): anchor, NaN for the wrist, length and standard deviation."""
    rows = [(*(np.full(3, np.nan) if it.anchor is None else it.anchor), it.length, it.sigma) for it in links]
    return np.array(rows, dtype=np.float64).reshape(-1, 5)


@compiled
def descend(
    views: tuple[tuple[Array, Array, Array, int], ...], links: Array, state: Array, iterations: int, converged_m: float
) -> tuple[Array, Array, float]:
    """Gauss-Newton from a state (6,), elbow then wrist: the state, its information (6, 6), the rms of the residuals.

    Views are projection, normals, offsets and number of elbow lines. The rms is NaN where it does not converge.
    """
    for _ in range(iterations):
        information, pull = np.zeros((6, 6)), np.zeros(6)
        squares, count = 0.0, len(links)
        for projection, normals, offsets, elbows in views:
            squares += _add_lines(projection, normals[:elbows], offsets[:elbows], state, 0, information, pull)
            squares += _add_lines(projection, normals[elbows:], offsets[elbows:], state, 3, information, pull)
            count += len(offsets)
        for k in range(len(links)):
            squares += _add_link(links[k], state, information, pull)
        if not np.isfinite(information).all() or abs(np.linalg.det(information / np.trace(information))) < TINY:
            break
        step = -np.linalg.solve(information, pull)
        state = state + step
        if np.sqrt(np.sum(step**2)) < converged_m:
            return state, information, math.sqrt(squares / count)
    return state, np.eye(6), math.nan


@compiled
def _add_lines(
    projection: Array, normals: Array, offsets: Array, state: Array, first: int, information: Array, pull: Array
) -> float:
    """Add image lines through a joint, the three numbers of the state from `first` on."""
    h = projection[:, 3].copy()
    for d in range(3):
        h += projection[:, d] * state[first + d]
    x, y = h[0] / h[2], h[1] / h[2]
    slope_x = (projection[0, :3] - x * projection[2, :3]) / h[2]
    slope_y = (projection[1, :3] - y * projection[2, :3]) / h[2]
    squares = 0.0
    for k in range(len(offsets)):
        row = normals[k, 0] * slope_x + normals[k, 1] * slope_y
        residual = normals[k, 0] * x + normals[k, 1] * y - offsets[k]
        squares += residual * residual
        for p in range(3):
            pull[first + p] += row[p] * residual
            for q in range(3):
                information[first + p, first + q] += row[p] * row[q]
    return squares


@compiled
def _add_link(link: Array, state: Array, information: Array, pull: Array) -> float:
    """Add a known distance of the elbow."""
    anchored = not math.isnan(link[0])
    arm = (link[:3] if anchored else state[3:]) - state[:3]
    length = max(math.sqrt(arm[0] ** 2 + arm[1] ** 2 + arm[2] ** 2), MIN_LENGTH)
    row = np.zeros(6)
    row[:3] = -arm / (length * link[4])
    if not anchored:
        row[3:] = -row[:3]
    residual = (length - link[3]) / link[4]
    for p in range(6):
        pull[p] += row[p] * residual
        for q in range(6):
            information[p, q] += row[p] * row[q]
    return float(residual * residual)
