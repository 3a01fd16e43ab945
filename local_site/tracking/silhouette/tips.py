"""Finger tips: a fitted tip moved to the edges around it, as no hand is exactly the model, with its covariance."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import image_of
from local_site.kernels.compiled import compiled
from local_site.kernels.pictures import grey_at
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS, MIN_VIEWS, HandView, contact, padded
from local_site.tracking.silhouette.hand_model.landmark_equations import landmark_of
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES, INDEX_TIP, THUMB_TIP, HandSpheres

FREEDOM_M = 0.008  # of a tip in its model
SHAPE_SIGMA_M = 0.001
MISFIT_WEIGHT = 0.1
PIXEL_SIGMA = 1.4
REACH_PX, REACH_RADII = 3.0, 0.9  # how far from a tip its edges are searched
CAP_BACK = 0.3
AHEAD = 0.7
EDGE_SIGMA = 2.5
EDGE_ANGLES = np.radians(np.arange(-75.0, 76.0, 15.0))
EDGE_STEPS = 12
MIN_EDGE = 0.08
MIN_DISTANCE_PX = 1e-6
MIN_PIXELS, END_RADII = 3, 0.7  # outline pixels ahead of the tip: at least, and in units of its radius
STEPS = 3

TipSphere = tuple[Array, Array, float]
"""Centre of the tip's sphere (3,), of the joint before it (3,), and its radius, in m."""

Circle = tuple[Array, float, Array, Array]
"""A tip in a view: centre (2,) and radius in px, direction of the finger (2,), px per m (2, 3)."""


@dataclass(frozen=True, slots=True)
class Finger:
    """A finger by the number of its last sphere, and the error model of its tip.

    `edges` weights the covariance from its edges, `depth_sigma_m` is how deep in its round end the tip lies,
    `hidden_sigmas_m` is the model's error where no view and where one view shows the end in outline.
    """

    sphere: int
    edges: float
    depth_sigma_m: float
    hidden_sigmas_m: tuple[float, float]


# The index's end is seldom hidden by more than another finger, in front of which its grey edges are visible; the thumb
# disappears behind the hand, where only habit predicts it.
INDEX = Finger(INDEX_TIP, 1.0, 0.0, (0.0025, 0.0025))
THUMB = Finger(THUMB_TIP, 0.35, 0.0045, (0.019, 0.0095))


@dataclass(frozen=True, slots=True)
class Tip:
    """A finger tip on the skin (3,), its covariance (3, 3) in m², and how many views show it in outline."""

    point: Array
    covariance: Array
    views: int


def find_tips(views: Sequence[HandView], spheres: HandSpheres, fingers: Sequence[Finger]) -> list[Tip]:
    """The tips of a fitted hand's fingers.

    A tip's sphere may leave its position in the model by a few millimetres towards the outline pixels around it.
    """
    capsules = [contact(view, spheres, view.outline).capsule for view in views]
    capsules += [np.empty(0, np.intp)] * (MAX_VIEWS - len(views))
    tips = []
    for finger in fingers:
        sphere = finger.sphere
        tip = (spheres.centres[sphere], spheres.centres[sphere - 1], float(spheres.radii[sphere]))
        shift, spread, seen = _settle(
            padded(views), tuple(capsules), CAPSULES[:, 1] == sphere, tip, landmark_of(sphere)
        )
        point = spheres.tip(sphere) + shift
        rays = [point + np.linalg.solve(v.projection[:, :3], v.projection[:, 3]) for v in views]
        sight = np.mean([ray / np.linalg.norm(ray) for ray in rays], axis=0)
        tips.append(Tip(point, _covariance(finger, shift, spread, seen, sight), seen))
    return tips


def _covariance(finger: Finger, shift: Array, spread: Array, seen: int, sight: Array) -> Array:
    """The covariance (3, 3) from the edges, and from what no edge shows: shape, depth, occlusion, and the deviation
    of this hand from its model."""
    variance = SHAPE_SIGMA_M**2 + MISFIT_WEIGHT * float(shift @ shift) / 3
    if seen < MIN_VIEWS:
        variance += finger.hidden_sigmas_m[seen] ** 2
    depth = finger.depth_sigma_m**2 * np.outer(sight, sight)
    result: Array = finger.edges * spread + variance * np.eye(3) + depth
    return result


@compiled
def _settle(
    views: tuple[HandView, ...],
    capsules: tuple[NDArray[np.intp], ...],
    owned: NDArray[np.bool_],
    tip: TipSphere,
    landmark: int,
) -> tuple[Array, Array, int]:
    """Move a tip to its edges: its shift (3,), the covariance (3, 3) of that, and how many views show it in outline.

    `capsules` (M,) are those that each outline pixel of a view touches; `owned` marks those (K,) that end in the tip.
    Grey edges serve only without landmarks, which find the tip better where another finger or the room has edges too.
    """
    shift, information, seen, has_landmark = np.zeros(3), np.eye(3), 0, False
    for view in views:
        has_landmark = has_landmark or _shows(view, landmark)
    for _ in range(STEPS):
        information, pull, seen = np.eye(3) / FREEDOM_M**2, shift / FREEDOM_M**2, 0
        moved = (tip[0] + shift, tip[1] + shift, tip[2])
        for k in range(len(views)):
            view = views[k]
            shown = _shows(view, landmark)
            if view.grey.size == 0 and not shown:
                continue
            circle = _circle(view, moved)
            if shown:
                _add_landmark(circle, view.landmarks[landmark], view.landmark_sigma, information, pull)
            if view.grey.size == 0:
                continue
            ahead = _add_outline(circle, view.outline, owned, capsules[k], information, pull)
            if ahead >= max(MIN_PIXELS, END_RADII * circle[1]):
                seen += 1
            elif not has_landmark:
                _add_grey_edges(circle, view, information, pull)
        shift = shift - np.linalg.solve(information, pull)
    return shift, np.linalg.inv(information).astype(np.float64), seen


@compiled
def _shows(view: HandView, landmark: int) -> bool:
    """Return whether the view has a landmark, by its number."""
    return len(view.landmarks) > 0 and not np.isnan(view.landmarks[landmark, 0])


@compiled
def _circle(view: HandView, tip: TipSphere) -> Circle:
    """The tip in the view."""
    centre, gradient, depth = image_of(view.projection, tip[0])
    ahead = centre - image_of(view.projection, tip[1])[0]
    ahead /= max(math.sqrt(ahead[0] ** 2 + ahead[1] ** 2), MIN_DISTANCE_PX)
    return centre, tip[2] * view.focal_px / depth, ahead, gradient


@compiled
def _add(
    gradient: Array, nx: float, ny: float, residual_px: float, sigma: float, information: Array, pull: Array
) -> None:
    row = -(nx * gradient[0] + ny * gradient[1]) / sigma
    for p in range(3):
        pull[p] += row[p] * residual_px / sigma
        for q in range(3):
            information[p, q] += row[p] * row[q]


@compiled
def _add_landmark(circle: Circle, landmark: Array, sigma: float, information: Array, pull: Array) -> None:
    """Add the landmark (2,) in px of a tip: the centre of its round end."""
    centre, _, _, gradient = circle
    _add(gradient, 1.0, 0.0, landmark[0] - centre[0], sigma, information, pull)
    _add(gradient, 0.0, 1.0, landmark[1] - centre[1], sigma, information, pull)


@compiled
def _add_outline(
    circle: Circle,
    outline: Array,
    owned: NDArray[np.bool_],
    capsules: NDArray[np.intp],
    information: Array,
    pull: Array,
) -> int:
    """Add the tip's own outline pixels near its end to information (3, 3) and pull (3,).

    Returns how many lie ahead of it: an outline that only passes beside a tip does not show where it ends.
    """
    centre, radius, ahead, gradient = circle
    count = 0
    for n in range(len(outline)):
        if not owned[capsules[n]]:
            continue
        x, y = outline[n, 0] - centre[0], outline[n, 1] - centre[1]
        distance = max(math.sqrt(x * x + y * y), MIN_DISTANCE_PX)
        forward = x * ahead[0] + y * ahead[1]
        if abs(distance - radius) < max(REACH_PX, REACH_RADII * radius) and forward > -CAP_BACK * radius:
            count += forward > AHEAD * distance
            _add(gradient, x / distance, y / distance, distance - radius, PIXEL_SIGMA, information, pull)
    return count


@compiled
def _add_grey_edges(circle: Circle, view: HandView, information: Array, pull: Array) -> None:
    """Add the strongest grey edges on rays from the tip's centre, where it ends before or beside another finger."""
    centre, radius, ahead, gradient = circle
    values = np.empty(EDGE_STEPS + 1)
    for angle in EDGE_ANGLES:
        nx = math.cos(angle) * ahead[0] - math.sin(angle) * ahead[1]
        ny = math.sin(angle) * ahead[0] + math.cos(angle) * ahead[1]
        for k in range(EDGE_STEPS + 1):
            along = radius - REACH_PX + 2 * REACH_PX * k / EDGE_STEPS
            x, y = centre[0] + along * nx, centre[1] + along * ny
            values[k] = grey_at(view.grey, x - view.shift[0], y - view.shift[1])
        best, strongest = 0, 0.0
        for k in range(1, EDGE_STEPS):
            change = abs(values[k + 1] - values[k - 1])
            if change > strongest:
                best, strongest = k, change
        if strongest > MIN_EDGE * max(values.max(), 1.0):
            residual = -REACH_PX + 2 * REACH_PX * best / EDGE_STEPS
            _add(gradient, nx, ny, residual, EDGE_SIGMA, information, pull)
