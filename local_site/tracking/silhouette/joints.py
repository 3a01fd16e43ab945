"""Elbow and wrist in 3D with covariances: least squares of medial lines, wrist necks and the forearm's length.

The planes through the medial lines of both views bound the elbow (thesis 3.2.8, 3.2.9) and the forearm's axis; the neck
seen at the wrist and the known forearm length (thesis 3.2.10) take over where the planes leave a direction open.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import reprojection_residual, triangulate
from local_site.kernels.compiled import compiled
from local_site.tracking.features.features import Features
from local_site.tracking.silhouette.joint_equations import descend
from local_site.tracking.silhouette.limbs import (
    ELBOW,
    SHOULDER_END,
    WRIST,
    Limbs,
    elbow_shifts,
    image_motion,
    px_per_m,
    unit,
)

LENGTH_SIGMA = 0.015
SLEEVE_SIGMA = 0.1
MAX_SLEEVE_RESIDUAL = 0.7
MIN_PLANE_SINE = 0.12
MIN_UPPER_ARM_M = 0.02
SHIFT_ROUNDS = 2


@dataclass(frozen=True, slots=True)
class Body:
    """Elbow to wrist and elbow to sleeve end in m once they are known."""

    forearm_length: float | None = None
    sleeve_distance: float | None = None


@dataclass(frozen=True, slots=True)
class Joints:
    """Elbow and wrist (3,) in m with covariance (6, 6) in m², and the rms of their weighted residuals.

    `upper_arm` is a unit vector (3,) from the elbow to the shoulder, zero where it is not known.
    """

    elbow: Array
    wrist: Array
    covariance: Array
    misfit: float
    upper_arm: Array

    @property
    def elbow_sigma(self) -> float:
        """Standard deviation of the elbow along its worst direction, m."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance[:3, :3])[-1]))

    @property
    def wrist_sigma(self) -> float:
        """Standard deviation of the wrist along its worst direction, m."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance[3:, 3:])[-1]))


def solve_joints(views: Limbs, features: Sequence[Features], body: Body) -> Joints | None:
    """Elbow and wrist from two or more views; None if the least squares do not converge."""
    projections = list(views["projection"])
    start = [triangulate(projections, list(views["guess"][:, joint])) for joint in (ELBOW, WRIST, SHOULDER_END)]
    links = _links(body, sleeve_end(projections, features))
    state, information, misfit, upper_arm = _solve(views, links, *start)
    if math.isnan(misfit):
        return None
    covariance = np.linalg.inv(information).astype(np.float64)
    return Joints(state[:3], state[3:], covariance, misfit, upper_arm)


@compiled
def _solve(views: Limbs, links: Array, elbow: Array, wrist: Array, far_end: Array) -> tuple[Array, Array, float, Array]:
    """The state (6,) with its information and misfit, and the upper arm's direction (3,), zero where it is not known.

    Iterated, because the position of the elbow's axis in the limbs depends on the bend.
    """
    shifts, upper_arm = np.zeros((len(views), 2)), np.zeros(3)
    state, information, misfit = descend(views, links, shifts, np.concatenate((elbow, wrist)))
    for _ in range(1, SHIFT_ROUNDS):
        found, direction = upper_arm_direction(views, state[:3], far_end)
        if not found or math.isnan(misfit):
            break
        upper_arm = direction
        forearm = unit(state[3:] - state[:3])
        for k in range(len(views)):
            shifts[k] = elbow_shifts(views[k], state[:3], forearm, upper_arm)
        state, information, misfit = descend(views, links, shifts, state)
    return state, information, misfit, upper_arm


def sleeve_end(projections: Sequence[Array], features: Sequence[Features]) -> Array | None:
    """The upper arm's end (3,) in m; None if the image border cuts it or the views disagree."""
    if any(f.silhouette.at_border or f.upper_arm is None for f in features):
        return None
    pixels = [f.guess.shoulder_end for f in features]
    point = triangulate(projections, pixels)
    residual = reprojection_residual(projections, pixels, point)
    return point if residual < MAX_SLEEVE_RESIDUAL * min(f.half_width for f in features) else None


def _links(body: Body, sleeve: Array | None) -> Array:
    """Known distances of the elbow as rows (N, 5): anchor, NaN for the wrist, length and standard deviation, m."""
    rows = []
    if body.forearm_length is not None:
        rows.append((math.nan, math.nan, math.nan, body.forearm_length, LENGTH_SIGMA * body.forearm_length))
        if body.sleeve_distance is not None and sleeve is not None:
            rows.append((*sleeve.tolist(), body.sleeve_distance, SLEEVE_SIGMA * body.forearm_length))
    return np.array(rows, dtype=np.float64).reshape(-1, 5)


@compiled
def upper_arm_direction(views: Limbs, elbow: Array, far_end: Array) -> tuple[bool, Array]:
    """Find whether it is known, and the unit vector (3,) from the elbow to the shoulder: where the planes of the upper
    arm's lines intersect.

    If the planes nearly coincide, as for an upper arm parallel to the baseline, or one view alone shows it, it is the
    direction in that plane to the far end (3,) in m.
    """
    spread, seen = np.zeros((3, 3)), 0
    for k in range(len(views)):
        if views[k].has_upper_arm:
            normal = plane_normal(views[k].projection, views[k].upper_arm)
            seen += 1
            for p in range(3):
                spread[p] += normal[p] * normal
    if seen < 1:
        return False, np.zeros(3)
    squares, axes = np.linalg.eigh(spread)
    if seen < 2 or squares[1] < MIN_PLANE_SINE**2:
        common = np.ascontiguousarray(axes[:, 2])
        towards = far_end - elbow
        towards = towards - common * np.sum(common * towards)
        return bool(np.sum(towards**2) > MIN_UPPER_ARM_M**2), unit(towards)
    meeting, votes = np.ascontiguousarray(axes[:, 0]), 0.0
    for k in range(len(views)):
        if views[k].has_upper_arm:
            votes += np.sum(views[k].upper_arm[1] * image_motion(views[k].projection, elbow, meeting))
    return True, meeting if votes > 0 else -meeting


@compiled
def plane_normal(projection: Array, line: Array) -> Array:
    """The unit normal (3,) of the plane through a camera's centre and an image line, a point and a direction (2, 2)."""
    point, direction = line[0], line[1]
    ahead = projection[1, :3] * direction[0] - projection[0, :3] * direction[1]
    return unit(ahead - (point[1] * direction[0] - point[0] * direction[1]) * projection[2, :3])


# variances of the limbs' lines relative to those that weight them in the least squares
ELBOW_LINES, WRIST_LINES = 0.3, 0.5
# half a limb's width that is bone and skin in every person; the rest is flesh, in which the elbow's axis lies
BONE_M = 0.015
AXIS_SIGMA, STRAIGHT_SIGMA = 0.13, 0.2  # of the flesh: in the arm's plane; along the forearm, times cot(bend)
MAX_COTANGENT = 2.0
NECK_SIGMA_M = 0.0025  # where the palm begins, along the forearm
PLANE_SINE = 0.05


def elbow_covariance(joints: Joints, views: Limbs) -> Array:
    """The elbow's covariance (3, 3) in m²: the limbs' lines, and where in the flesh its axis lies.

    Flesh moves the axis in the plane in which the arm bends, the farther along the forearm the straighter the arm is.
    """
    flesh = _flesh(views, joints.elbow, joints.wrist, joints.upper_arm)
    result: Array = ELBOW_LINES * joints.covariance[:3, :3] + flesh
    return result


def wrist_covariance(joints: Joints) -> Array:
    """The wrist's covariance (3, 3) in m²: the limbs' lines, and where the palm begins."""
    forearm = unit(joints.wrist - joints.elbow)
    result: Array = WRIST_LINES * joints.covariance[3:, 3:] + NECK_SIGMA_M**2 * np.outer(forearm, forearm)
    return result


@compiled
def _flesh(views: Limbs, elbow: Array, wrist: Array, upper_arm: Array) -> Array:
    """Compute what the flesh adds (3, 3); `upper_arm` (3,) is a unit vector from the elbow, zero where not known."""
    half_width = 0.0
    for k in range(len(views)):
        half_width += views[k].half_width / px_per_m(views[k], elbow) / len(views)
    forearm = unit(wrist - elbow)
    cosine = np.sum(forearm * upper_arm)
    hinge = np.cross(forearm, upper_arm)
    sine = np.sqrt(np.sum(hinge**2))
    plane = np.eye(3)
    if sine > PLANE_SINE:
        plane -= np.outer(hinge, hinge) / sine**2
    cotangent = min(abs(cosine) / max(sine, 1e-9), MAX_COTANGENT)
    relative = AXIS_SIGMA**2 * plane + (STRAIGHT_SIGMA * cotangent) ** 2 * np.outer(forearm, forearm)
    covariance: Array = max(half_width - BONE_M, 0.0) ** 2 * relative
    return covariance
