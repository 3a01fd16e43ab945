"""Gauss-Newton for elbow and wrist: residuals in standard deviations of the lines in the views; compiled."""

import math

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import image_of
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.limbs import ELBOW, WRIST, Limbs, SilhouetteLimb

FOREARM_SIGMA = 0.06
ROOT_SIGMA, UPPER_ARM_SIGMA = 0.08, 0.1
NECK_SIGMA = 0.3
ROUGH_SIGMA = 3.0
EXPECTED_SIGMA = 1.0
CLEAR_BEND_SINE = 0.6
MIN_BEND_SINE = 0.02
MIN_LENGTH = 1e-6
TINY = 1e-40
ITERATIONS = 12
CONVERGED_M = 1e-5
OF_ELBOW, OF_WRIST = 0, 3  # of the joints in the state


@compiled
def descend(views: Limbs, links: Array, shifts: Array, state: Array) -> tuple[Array, Array, float]:
    """Gauss-Newton from a state (6,), elbow then wrist: the state, its information (6, 6), the rms of the residuals.

    `links` (N, 5) are known distances of the elbow: anchor, NaN for the wrist, length and standard deviation, in m;
    `shifts` (V, 2) the offsets in px of the elbow's axis from a view's lines. The rms is NaN if it does not converge.
    """
    for _ in range(ITERATIONS):
        information, pull = np.zeros((6, 6)), np.zeros(6)
        squares, count = 0.0, len(links)
        for k in range(len(views)):
            squares += _add_view(views[k], shifts[k], state, information, pull)
            count += 4 + views[k].has_upper_arm
        for k in range(len(links)):
            squares += _add_link(links[k], state, information, pull)
        if not np.isfinite(information).all() or abs(np.linalg.det(information / np.trace(information))) < TINY:
            break
        step = -np.linalg.solve(information, pull)
        state = state + step
        if np.sqrt(np.sum(step**2)) < CONVERGED_M:
            return state, information, math.sqrt(squares / count)
    return state, np.eye(6), math.nan


@compiled
def _add_view(view: SilhouetteLimb, shifts: Array, state: Array, information: Array, pull: Array) -> float:
    """Add the lines of a view; the sigmas are fractions of the limb's half width, so that they scale with the distance.

    The elbow's expected position along the forearm has little weight, for when nothing else determines it, and hardly
    any where the view does not show the upper arm: there the border may have cut the arm before the elbow. If the arm
    looks nearly straight, a small offset of the upper arm's line would move the intersection far along the arm.
    """
    elbow, wrist = image_of(view.projection, state[:3]), image_of(view.projection, state[3:])
    ahead, width = view.forearm[1], view.half_width
    root = _across(view.root[0], view.root[1], shifts[0])
    squares = _add_line(elbow, root, ROOT_SIGMA * width, OF_ELBOW, information, pull)
    axis = _across(view.forearm[0], ahead, 0.0)
    squares += _add_line(wrist, axis, FOREARM_SIGMA * width, OF_WRIST, information, pull)
    expected = EXPECTED_SIGMA if view.has_upper_arm else ROUGH_SIGMA
    squares += _add_line(elbow, _at(view.guess[ELBOW], ahead), expected * width, OF_ELBOW, information, pull)
    neck = NECK_SIGMA if view.has_wrist else ROUGH_SIGMA
    squares += _add_line(wrist, _at(view.guess[WRIST], ahead), neck * width, OF_WRIST, information, pull)
    if view.has_upper_arm:
        upper = view.upper_arm[1]
        bend = max(abs(upper[0] * ahead[1] - upper[1] * ahead[0]), MIN_BEND_SINE)
        sigma = UPPER_ARM_SIGMA * max(1.0, CLEAR_BEND_SINE / bend) ** 2 * width
        line = _across(view.upper_arm[0], upper, shifts[1])
        squares += _add_line(elbow, line, sigma, OF_ELBOW, information, pull)
    return squares


@compiled
def _add_line(
    image: tuple[Array, Array, float],
    line: tuple[float, float, float],
    sigma: float,
    joint: int,
    information: Array,
    pull: Array,
) -> float:
    """Add an image line through a joint: normal x and y, and offset in px."""
    (x, y), (slope_x, slope_y), _ = image
    nx, ny, offset = line
    residual = (nx * x + ny * y - offset) / sigma
    for p in range(3):
        row = (nx * slope_x[p] + ny * slope_y[p]) / sigma
        pull[joint + p] += row * residual
        for q in range(3):
            information[joint + p, joint + q] += row * (nx * slope_x[q] + ny * slope_y[q]) / sigma
    return float(residual * residual)


@compiled
def _across(point: Array, direction: Array, shift: float) -> tuple[float, float, float]:
    """The line `shift` px beside the one along a direction."""
    nx, ny = -direction[1], direction[0]
    return nx, ny, nx * point[0] + ny * point[1] + shift


@compiled
def _at(point: Array, direction: Array) -> tuple[float, float, float]:
    """The line through a point that a direction crosses at right angles."""
    return direction[0], direction[1], direction[0] * point[0] + direction[1] * point[1]


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
