"""Gauss-Newton on a hand's outlines, compiled from end to end, so that many starts can be tried."""

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.hand_model.kernels import (
    add_outline,
    add_outside,
    capsule_frames,
    project_spheres,
    touch,
)
from local_site.tracking.silhouette.hand_model.placement import POSE, STATE, place_spheres, rotation_vector, turned
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES

ROBUST_SIGMAS = 1.5
OUTSIDE = (3.0, 2.0)
MAX_TURN = 0.35
SMALL_STEP = 0.01
CONTAINED = 20

ViewArrays = tuple[Array, float, Array, NDArray[np.float32], Array, float]
"""Projection (3, 4), focal length in px, outline pixels (N, 2), distance field (H, W), its origin (2,), sigma in px."""

Known = tuple[Array, Array, Array, Array]
"""What is known before: wrist (3,), rotation (3, 3), posture (10,), information (16, 16)."""

Body = tuple[float, bool, Array]
"""Size against the average hand, whether it is a right one, wrist to the forearm's spheres (3,) in m."""


@compiled
def descend(
    views: tuple[ViewArrays, ...],
    wrist: Array,
    rotation: Array,
    posture: Array,
    known: Known,
    body: Body,
    iterations: int,
) -> tuple[Array, Array, Array, Array, float]:
    """Wrist, rotation and posture improved, the outlines' information (16, 16), and the cost per outline pixel."""
    information, gradient = np.zeros((STATE, STATE)), np.zeros(STATE)
    cost, strain = 0.0, np.zeros(STATE)
    for _ in range(iterations):
        information[:], gradient[:] = 0.0, 0.0
        cost = _add_views(views, wrist, rotation, posture, body, information, gradient)
        information += np.tril(information, -1).T
        strain = _strain(wrist, rotation, posture, known)
        step = np.linalg.solve(information + known[3], -gradient - known[3] @ strain).astype(np.float64)
        turn = max(np.sqrt(np.sum(step[3:POSE] ** 2)), np.abs(step[POSE:]).max())
        step = step * min(1.0, MAX_TURN / max(turn, 1e-9))
        wrist, rotation, posture = wrist + step[:3], turned(step[3:POSE]) @ rotation, posture + step[POSE:]
        if max(turn, 10 * np.sqrt(np.sum(step[:3] ** 2))) < SMALL_STEP:
            break
    count = 0
    for view in views:
        count += len(view[2])
    strained = float(strain @ known[3] @ strain)
    return wrist, rotation, posture, information, (cost + strained) / max(count, 1)


@compiled
def _add_views(
    views: tuple[ViewArrays, ...],
    wrist: Array,
    rotation: Array,
    posture: Array,
    body: Body,
    information: Array,
    gradient: Array,
) -> float:
    spheres = place_spheres(wrist, rotation, posture, body[0], body[1], body[2])
    cost = 0.0
    for projection, focal_px, pixels, field, origin, sigma in views:
        if len(pixels) == 0:
            continue
        circles = project_spheres(projection, focal_px, spheres[0], spheres[1], spheres[2], spheres[3])
        frames = capsule_frames(circles[0], circles[1], CAPSULES)
        contact = touch(pixels, circles[0], circles[1], CAPSULES, frames)
        cost += add_outline(pixels, contact, circles, CAPSULES, sigma, ROBUST_SIGMAS, information, gradient)
        cost += add_outside(field, origin, circles, CONTAINED, sigma, OUTSIDE, information, gradient)
    return cost


@compiled
def _strain(wrist: Array, rotation: Array, posture: Array, known: Known) -> Array:
    """How far a hand is from what was known of it, (16,)."""
    strain = np.empty(STATE)
    strain[:3] = wrist - known[0]
    strain[3:POSE] = rotation_vector(rotation @ known[1].T)
    strain[POSE:] = posture - known[2]
    return strain
