"""Fits the hand model to outlines and landmarks in all views at once by Gauss-Newton, regularised by a prior.

The iteration is compiled from end to end, so that many starts can be tried.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.hand_model.landmark_equations import add_landmarks
from local_site.tracking.silhouette.hand_model.outline_equations import (
    Contact,
    add_outline,
    add_outside,
    project_spheres,
    touch,
)
from local_site.tracking.silhouette.hand_model.skeleton import (
    ABDUCTION,
    MIDDLE_TIP,
    PARAMETERS,
    POSE,
    SPREAD,
    STATE,
    HandPose,
    HandSpheres,
    Person,
    hand_spheres,
    rotation_vector,
    turned,
)

MIN_VIEWS = 2
# The compiled functions take one number of views, so that they are compiled once.
MAX_VIEWS = 4
ROBUST_SIGMAS = 1.5  # the Cauchy cost's scale
OUTSIDE = (3.0, 2.0)  # weight of a sphere outside the silhouette; standard deviations beyond which it has less
MAX_TURN = 0.35  # rad in one step, of the hand or of a joint
SMALL_STEP = 0.01  # rad, or a tenth of it in m: a smaller step is the last
CONTAINED = 20  # the first spheres, of fingers and thumb, are to lie within the silhouette
# Angles, rad, at which joints stop: fingers do not cross, and a thumb does not pass through the palm.
LEAST = np.full(PARAMETERS, -np.inf)
LEAST[SPREAD], LEAST[ABDUCTION] = -0.2, 0.1
STOP_SIGMA = 0.04


class HandView(NamedTuple):
    """The hand in one view.

    Projection (3, 4) and its focal length in px; outline pixels (N, 2); the silhouette's distance field (H, W) in px,
    positive inside, whose first pixel is at `origin` (2,); the standard deviation in px of an outline pixel from the
    model, which includes the model's own error; the whole outline (M, 2), from which `pixels` are sampled; the grey
    picture, empty where there is no outline, and the shift (2,) that takes it to the instant measured; the hand's 21
    landmarks (21, 2) in px, NaN where unknown, none (0, 2) where all are, and their standard deviation in px.
    """

    projection: Array
    focal_px: float
    pixels: Array
    field: NDArray[np.float32]
    origin: Array
    sigma: float
    outline: Array
    grey: NDArray[np.uint8]
    shift: Array
    landmarks: Array
    landmark_sigma: float


NO_PIXELS = np.empty((0, 2))
NO_VIEW = HandView(
    np.eye(3, 4),
    1.0,
    NO_PIXELS,
    np.zeros((4, 4), np.float32),
    np.zeros(2),
    1.0,
    NO_PIXELS,
    np.empty((0, 0), np.uint8),
    np.zeros(2),
    NO_PIXELS,
    1.0,
)


class Prior(NamedTuple):
    """The prior: wrist (3,) in m, rotation (3, 3), posture (10,), and the information matrix (16, 16) about them."""

    wrist: Array
    rotation: Array
    posture: Array
    information: Array


@dataclass(frozen=True, slots=True)
class HandFit:
    """A fitted hand with the information (16, 16) about it, the prior's included, and the cost per outline pixel and
    landmark, in squared standard deviations."""

    pose: HandPose
    prior: Prior
    person: Person
    information: Array
    cost: float

    @property
    def spheres(self) -> HandSpheres:
        """Its spheres, in m."""
        return hand_spheres(self.pose, self.person)


def padded(views: Sequence[HandView]) -> tuple[HandView, ...]:
    """Fill up the views to MAX_VIEWS, the number that the compiled functions take."""
    return (*views, *[NO_VIEW] * (MAX_VIEWS - len(views)))


def fit_hand(views: Sequence[HandView], start: HandPose, prior: Prior, person: Person, iterations: int) -> HandFit:
    """Improve a hand from a start; the prior decides what the outlines leave undetermined."""
    pose, information, cost = _descend(padded(views), start, prior, person, iterations)
    return HandFit(pose, prior, person, information + prior.information, cost)


def contact(view: HandView, spheres: HandSpheres, pixels: Array) -> Contact:
    """Compute the contacts of pixels (N, 2) of a view with a hand."""
    return touch(pixels, project_spheres(view.projection, view.focal_px, spheres))


@compiled
def _descend(
    views: tuple[HandView, ...], start: HandPose, prior: Prior, person: Person, iterations: int
) -> tuple[HandPose, Array, float]:
    """Return the improved hand, the views' information (16, 16), and the cost per outline pixel and landmark.

    The latter two are those before the last step.
    """
    wrist, rotation, posture = start
    information, gradient = np.zeros((STATE, STATE)), np.zeros(STATE)
    cost, stopped, strain = 0.0, 0.0, np.zeros(STATE)
    for _ in range(iterations):
        information[:], gradient[:] = 0.0, 0.0
        cost = _add_views(views, hand_spheres(HandPose(wrist, rotation, posture), person), information, gradient)
        information += np.tril(information, -1).T
        strain[:3] = wrist - prior.wrist
        strain[3:POSE] = rotation_vector(rotation @ prior.rotation.T)
        strain[POSE:] = posture - prior.posture
        known = information + prior.information
        stopped = _add_stops(posture, known, gradient)
        # After a step the cost is |r + J step|^2 + (s + step)^T P (s + step), with the residuals r and the strain s.
        # Its derivative is zero where (J^T J + P) step = -J^T r - P s; `known` is J^T J + P, `gradient` is J^T r.
        step = np.linalg.solve(known, -gradient - prior.information @ strain)
        turn = max(np.sqrt(np.sum(step[3:POSE] ** 2)), np.abs(step[POSE:]).max())
        step = step * min(1.0, MAX_TURN / max(turn, 1e-9))
        wrist, rotation, posture = wrist + step[:3], turned(step[3:POSE]) @ rotation, posture + step[POSE:]
        if max(turn, 10 * np.sqrt(np.sum(step[:3] ** 2))) < SMALL_STEP:
            break
    count = 0
    for view in views:
        count += len(view.pixels) + len(view.landmarks)
    strained = float(strain @ prior.information @ strain) + stopped
    return HandPose(wrist, rotation, posture), information, (cost + strained) / max(count, 1)


@compiled
def _add_stops(posture: Array, information: Array, gradient: Array) -> float:
    """Add the joints that are beyond their stops to the normal equations; return their cost."""
    cost = 0.0
    for p in range(PARAMETERS):
        beyond = (posture[p] - LEAST[p]) / STOP_SIGMA
        if beyond < 0.0:  # a residual, whose derivative by the angle is 1 / STOP_SIGMA
            information[POSE + p, POSE + p] += 1 / STOP_SIGMA**2
            gradient[POSE + p] += beyond / STOP_SIGMA
            cost += beyond * beyond
    return cost


@compiled
def _add_views(views: tuple[HandView, ...], spheres: HandSpheres, information: Array, gradient: Array) -> float:
    """Add outlines and landmarks of all views to the normal equations; return their cost."""
    cost = 0.0
    for view in views:
        if len(view.pixels) == 0 and len(view.landmarks) == 0:
            continue
        circles, sigma = project_spheres(view.projection, view.focal_px, spheres), view.sigma
        contact = touch(view.pixels, circles)
        cost += add_outline(view.pixels, contact, circles, sigma, ROBUST_SIGMAS, information, gradient)
        if len(view.pixels) > 0:
            cost += add_outside(view.field, view.origin, circles, CONTAINED, sigma, OUTSIDE, information, gradient)
        cost += add_landmarks(view.landmarks, circles, view.landmark_sigma, ROBUST_SIGMAS, information, gradient)
    return cost


FIRST_ITERATIONS = 6
LAST_ITERATIONS = 8
COARSE_STEP = 2
PARALLEL = 1e-6


@dataclass(frozen=True, slots=True)
class Effort:
    """The extent of a search: `rolls` starts around the line to the far end, turned by `offset` of a step, each tilted
    by `tilts` in rad; the best `kept` are fitted fully."""

    rolls: int
    kept: int
    tilts: tuple[float, ...] = (-0.35, 0.0, 0.35)
    offset: float = 0.0


def search_hand(views: Sequence[HandView], far_end: Array, prior: Prior, person: Person, effort: Effort) -> HandFit:
    """Find the best fit from starts with the middle finger's tip towards `far_end` (3,) in m.

    All starts are fitted for a few iterations on some of the outline's pixels, the best fully on all.
    """
    coarse = [view._replace(pixels=np.ascontiguousarray(view.pixels[::COARSE_STEP])) for view in views]
    starts = _starts(far_end, prior, person, effort)
    rough = sorted(
        (fit_hand(coarse, start, prior, person, FIRST_ITERATIONS) for start in starts), key=lambda fit: fit.cost
    )
    fits = [fit_hand(views, fit.pose, prior, person, LAST_ITERATIONS) for fit in rough[: effort.kept]]
    return min(fits, key=lambda fit: fit.cost)


def _starts(far_end: Array, prior: Prior, person: Person, effort: Effort) -> list[HandPose]:
    local = hand_spheres(HandPose(np.zeros(3), np.eye(3), prior.posture), person).centres[MIDDLE_TIP]
    ahead = _frame(far_end - prior.wrist, -person.to_elbow)
    aligned = ahead @ _frame(local, np.array([0.0, 0.0, 1.0])).T
    angles = [2 * math.pi * (k + effort.offset) / effort.rolls for k in range(effort.rolls)]
    turns = [turned(angle * ahead[:, 0]) @ aligned for angle in angles]
    tilts = [turned(np.array([0.0, tilt, 0.0])) for tilt in effort.tilts]
    return [HandPose(prior.wrist, turn @ tilt, prior.posture) for turn in turns for tilt in tilts]


def _frame(first: Array, second: Array) -> Array:
    """The rotation (3, 3) with its first axis along one vector (3,) and the second as close as possible to another."""
    x = first / max(float(np.linalg.norm(first)), 1e-9)
    y = second - x * float(x @ second)
    if float(np.linalg.norm(y)) < PARALLEL:
        y = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))])
    y = y / float(np.linalg.norm(y))
    return np.column_stack([x, y, np.cross(x, y)])
