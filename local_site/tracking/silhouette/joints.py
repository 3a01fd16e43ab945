"""Elbow and wrist in 3D: the least-squares meeting of medial lines, wrist necks and the forearm's length.

The planes through the medial lines of both views bound the elbow (thesis 3.2.8, 3.2.9) and the forearm's axis; the neck
seen at the wrist and the known forearm length (thesis 3.2.10) take over where the planes leave a direction open.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import project, reprojection_residual, triangulate
from local_site.tracking.silhouette.elbow_depth import Bend, shifts_of
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS
from local_site.tracking.silhouette.joint_equations import (
    Constraints,
    Link,
    Shifts,
    constraints_of,
    descend,
    known_distances,
)

LENGTH_SIGMA = 0.015
SLEEVE_SIGMA = 0.1
MAX_SLEEVE_RESIDUAL = 0.7
ITERATIONS = 12
CONVERGED_M = 1e-5
MIN_PLANE_SINE = 0.12
MIN_UPPER_ARM_M = 0.02
SHIFT_ROUNDS = 2
NO_LINES = (np.eye(3, 4), np.empty((0, 2)), np.empty(0), 0)


@dataclass(frozen=True, slots=True)
class Body:
    """Elbow to wrist and elbow to sleeve end in m once they are known."""

    forearm_length: float | None = None
    sleeve_distance: float | None = None


@dataclass(frozen=True, slots=True)
class Joints:
    """Elbow and wrist (3,) in m with covariance (6, 6) in m², and the rms of their weighted residuals."""

    elbow: Array
    wrist: Array
    covariance: Array
    misfit: float

    @property
    def elbow_sigma(self) -> float:
        """Standard deviation of the elbow along its worst direction, m."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance[:3, :3])[-1]))

    @property
    def wrist_sigma(self) -> float:
        """Standard deviation of the wrist along its worst direction, m."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance[3:, 3:])[-1]))


def solve_joints(
    projections: Sequence[Array], features: Sequence[Features], body: Body, near: Joints | None = None
) -> Joints | None:
    """Elbow and wrist from the features of two or more views; `near` starts the iteration.

    Standard deviations of the measurements are fractions of each view's limb half width, so they scale with distance.
    None where the least squares do not converge.
    """
    if near is None:
        elbow = triangulate(projections, [f.guess.elbow for f in features])
        wrist = triangulate(projections, [f.guess.wrist for f in features])
        state = np.concatenate([elbow, wrist])
    else:
        state = np.concatenate([near.elbow, near.wrist])
    joints = None
    links = _links(body, sleeve_end(projections, features))
    shifts = [Shifts()] * len(features)
    for _ in range(SHIFT_ROUNDS):
        pairs = zip(projections, features, shifts, strict=True)
        joints = _solve([constraints_of(m, f, shift) for m, f, shift in pairs], links, state)
        if joints is None:
            return None
        upper = upper_arm_direction(projections, features, joints.elbow)
        if upper is None:
            return joints
        state = np.concatenate([joints.elbow, joints.wrist])
        bend = Bend(joints.elbow, joints.wrist, upper)
        shifts = [shifts_of(m, f, bend) for m, f in zip(projections, features, strict=True)]
    return joints


def sleeve_end(projections: Sequence[Array], features: Sequence[Features]) -> Array | None:
    """Where the upper arm ends in all views (3,) in m; None where the image border cuts it or the views disagree."""
    if any(f.shoulder_cropped or f.upper_arm is None for f in features):
        return None
    pixels = [f.guess.shoulder_end for f in features]
    point = triangulate(projections, pixels)
    residual = reprojection_residual(projections, pixels, point)
    return point if residual < MAX_SLEEVE_RESIDUAL * min(f.half_width for f in features) else None


def _links(body: Body, sleeve: Array | None) -> list[Link]:
    links = []
    if body.forearm_length is not None:
        links.append(Link(None, body.forearm_length, LENGTH_SIGMA * body.forearm_length))
        if body.sleeve_distance is not None and sleeve is not None:
            links.append(Link(sleeve, body.sleeve_distance, SLEEVE_SIGMA * body.forearm_length))
    return links


def upper_arm_direction(projections: Sequence[Array], features: Sequence[Features], elbow: Array) -> Array | None:
    """The unit vector (3,) from the elbow to the shoulder along which the planes of the upper arm's lines meet.

    Where the planes nearly coincide, as for an upper arm parallel to the baseline, it leads in their common plane to
    where the views' far ends of the upper arm meet.
    """
    seen = [(m, f, f.upper_arm) for m, f in zip(projections, features, strict=True) if f.upper_arm is not None]
    if len(seen) < 2:
        return None
    planes = np.array([line.normal @ (m[:2, :3] - np.outer(line.point, m[2, :3])) for m, _, line in seen])
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    _, singular, axes = np.linalg.svd(planes)
    if singular[1] < MIN_PLANE_SINE:
        far_end = triangulate([m for m, _, _ in seen], [f.guess.shoulder_end for _, f, _ in seen])
        direction = (far_end - elbow) - axes[0] * float(axes[0] @ (far_end - elbow))
        length = float(np.linalg.norm(direction))
        return direction / length if length > MIN_UPPER_ARM_M else None
    votes = [line.direction @ _image_motion(m, elbow, axes[2]) for m, _, line in seen]
    towards: Array = axes[2] if sum(votes) > 0 else -axes[2]
    return towards


def _image_motion(matrix: Array, point: Array, direction: Array) -> Array:
    """Pixels per m (2,) by which the image of a point (3,) moves along a direction (3,)."""
    depth = float(matrix[2, :3] @ point + matrix[2, 3])
    result: Array = (matrix[:2, :3] - np.outer(project(matrix, point), matrix[2, :3])) @ direction / depth
    return result


def _solve(constraints: Sequence[Constraints], links: Sequence[Link], state: Array) -> Joints | None:
    views = (*(c.arrays for c in constraints), *[NO_LINES] * (MAX_VIEWS - len(constraints)))
    state, information, misfit = descend(views, known_distances(links), state, ITERATIONS, CONVERGED_M)
    if math.isnan(misfit):
        return None
    return Joints(state[:3], state[3:], np.linalg.inv(information).astype(np.float64), misfit)
