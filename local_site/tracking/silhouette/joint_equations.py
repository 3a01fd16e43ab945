"""The equations between elbow, wrist and what the views show of them, in standard deviations."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.features import Features

FOREARM_SIGMA = 0.06
UPPER_ARM_SIGMA = 0.15
NECK_SIGMA = 0.3
ROUGH_SIGMA = 3.0
EXPECTED_SIGMA = 1.0
CLEAR_BEND_SINE = 0.4
MIN_BEND_SINE = 0.02
MIN_LENGTH = 1e-6


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


def linearise(constraints: Sequence[Constraints], state: Array, links: Sequence[Link]) -> tuple[Array, Array]:
    """Jacobian (M, 6) and residuals (M,) in standard deviations."""
    count = sum(len(c.offsets) for c in constraints)
    jacobian, residual = np.zeros((count + len(links), 6)), np.empty(count + len(links))
    row = 0
    for c in constraints:
        split, end = row + c.elbows, row + len(c.offsets)
        for rows, part, point, columns in (
            (slice(row, split), slice(0, c.elbows), state[:3], slice(0, 3)),
            (slice(split, end), slice(c.elbows, None), state[3:], slice(3, 6)),
        ):
            pixel, gradient = _pixel(c.projection, point)
            jacobian[rows, columns] = c.normals[part] @ gradient
            residual[rows] = c.normals[part] @ pixel - c.offsets[part]
        row = end
    for link in links:
        arm = (state[3:] if link.anchor is None else link.anchor) - state[:3]
        length = max(math.sqrt(float(arm @ arm)), MIN_LENGTH)
        jacobian[row, :3] = -arm / (length * link.sigma)
        if link.anchor is None:
            jacobian[row, 3:] = arm / (length * link.sigma)
        residual[row] = (length - link.length) / link.sigma
        row += 1
    return jacobian, residual


def _pixel(projection: Array, point: Array) -> tuple[Array, Array]:
    """The pixel (2,) of a point (3,) and its gradient (2, 3) in px per m."""
    x, y, depth = (projection[:, :3] @ point + projection[:, 3]).tolist()
    pixel = np.array([x / depth, y / depth])
    gradient: Array = (projection[:2, :3] - pixel[:, None] * projection[2, :3]) / depth
    return pixel, gradient
