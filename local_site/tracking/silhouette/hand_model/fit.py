"""Fits the hand model to outlines in all views at once, held by what is known beforehand."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.descent import descend
from local_site.tracking.silhouette.hand_model.kernels import capsule_frames, project_spheres, touch
from local_site.tracking.silhouette.hand_model.placement import HandPose, Person, Placed, place
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES, FOREARM_SPHERE_DISTANCE

MIN_VIEWS = 2
# one number of views for all, so that the descent is compiled once
MAX_VIEWS = 4
NO_VIEW = (np.zeros((3, 4)), 1.0, np.empty((0, 2)), np.zeros((4, 4), dtype=np.float32), np.zeros(2), 1.0)


@dataclass(frozen=True, slots=True)
class HandView:
    """The hand in one view: projection (3, 4) and its focal length, outline pixels (N, 2), distance field (H, W) in px,
    positive inside the silhouette, whose first pixel is at `origin` (2,), and the standard deviation in px of an
    outline pixel from the model, which differs more from a real hand than the pixel is uncertain; all of the outline
    (M, 2), of which the pixels are some, the picture, and the shift (2,) that takes it to the instant measured."""

    projection: Array
    focal_px: float
    pixels: Array
    field: NDArray[np.float32]
    origin: Array
    sigma: float
    outline: Array
    grey: NDArray[np.uint8]
    shift: Array


@dataclass(frozen=True, slots=True)
class Contact:
    """Where N outline pixels touch the model: signed distance (N,) in px, the capsule (N,), and the share (N,) of its
    length."""

    distance: Array
    capsule: NDArray[np.intp]
    share: Array


@dataclass(frozen=True, slots=True)
class Prior:
    """What is known before looking: wrist (3,) in m, posture (10,), a pose near which the rotation is expected, and the
    information matrix (16, 16) about them."""

    wrist: Array
    posture: Array
    information: Array
    near: HandPose | None = None


@dataclass(frozen=True)
class HandFit:
    """A fitted hand with the information (16, 16) about it, the prior's included, and the cost per outline pixel in
    squared standard deviations."""

    pose: HandPose
    prior: Prior
    person: Person
    information: Array
    cost: float

    @cached_property
    def placed(self) -> Placed:
        """Where its parts are."""
        return place(self.pose, self.person)


def fit_hand(views: Sequence[HandView], start: HandPose, prior: Prior, person: Person, iterations: int) -> HandFit:
    """Improve a hand from a start; the prior decides what the outlines leave open."""
    near = start.rotation if prior.near is None else prior.near.rotation
    known = (prior.wrist, near, prior.posture, prior.information)
    body = (person.scale, person.right_arm, person.scale * FOREARM_SPHERE_DISTANCE * person.to_elbow)
    arrays = [(v.projection, v.focal_px, v.pixels, v.field, v.origin, v.sigma) for v in views]
    padded = (*arrays, *[NO_VIEW] * (MAX_VIEWS - len(arrays)))
    state = descend(padded, start.wrist, start.rotation, start.posture, known, body, iterations)
    return HandFit(HandPose(*state[:3]), prior, person, state[3] + prior.information, state[4])


def contact(view: HandView, placed: Placed, pixels: Array) -> Contact:
    """Where pixels (N, 2) of a view touch a hand."""
    places, circles, _, _ = project_spheres(view.projection, view.focal_px, *placed.arrays)
    return Contact(*touch(pixels, places, circles, CAPSULES, capsule_frames(places, circles, CAPSULES)))
