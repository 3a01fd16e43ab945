"""Fits the hand model to outlines: robust Gauss-Newton in all views at once, held by what is known beforehand."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.kernels import (
    add_outline,
    add_outside,
    capsule_frames,
    project_spheres,
    touch,
)
from local_site.tracking.silhouette.hand_model.placement import POSE, STATE, HandPose, Person, Placed, place, turned
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES

ROBUST_SIGMAS = 1.5
OUTSIDE_WEIGHT = 3.0
OUTSIDE_SIGMAS = 2.0
MAX_TURN = 0.35
SMALL_STEP = 0.01
CONTAINED = 20


@dataclass(frozen=True, slots=True)
class HandView:
    """The hand in one view: projection (3, 4), outline pixels (N, 2), distance field (H, W) in px, positive inside the
    silhouette, whose first pixel is at `origin` (2,), and the standard deviation in px of an outline pixel from the
    model, which differs more from a real hand than the pixel is uncertain."""

    projection: Array
    pixels: Array
    field: NDArray[np.float32]
    origin: Array
    sigma: float
    grey: NDArray[np.uint8]


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


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted hand with the information (16, 16) about it, the prior's included, where its parts are, which parts the
    outline of each view touches, and the cost per outline pixel in squared standard deviations."""

    pose: HandPose
    prior: Prior
    placed: Placed
    information: Array
    contacts: tuple[Contact, ...]
    cost: float


@dataclass(frozen=True, slots=True)
class _System:
    information: Array
    gradient: Array
    contacts: tuple[Contact, ...]
    cost: float
    count: int


def fit_hand(views: Sequence[HandView], start: HandPose, prior: Prior, person: Person, iterations: int) -> Fit:
    """Improve a hand from a start; the prior decides what the outlines leave open."""
    pose, system = start, _linearise(views, start, person)
    for k in range(iterations):
        step = _step(pose, system, prior)
        pose = HandPose(pose.wrist + step[:3], turned(step[3:POSE]) @ pose.rotation, pose.posture + step[POSE:])
        small = max(float(np.abs(step[3:]).max()), 10 * float(np.abs(step[:3]).max())) < SMALL_STEP
        if small or k == iterations - 1:
            break
        system = _linearise(views, pose, person)
    strain = _strain(pose, prior)
    cost = (system.cost + float(strain @ prior.information @ strain)) / system.count
    information = system.information + prior.information
    return Fit(pose, prior, place(pose, person), information, system.contacts, cost)


def _linearise(views: Sequence[HandView], pose: HandPose, person: Person) -> _System:
    placed = place(pose, person)
    information, gradient = np.zeros((STATE, STATE)), np.zeros(STATE)
    cost, count, contacts = 0.0, 0, []
    for view in views:
        m, sums = view.projection, (information, gradient)
        circles = project_spheres(m, focal_length(m), *placed.arrays)
        contact = touch(view.pixels, circles[0], circles[1], CAPSULES, capsule_frames(circles[0], circles[1], CAPSULES))
        cost += add_outline(view.pixels, contact, circles, CAPSULES, view.sigma, ROBUST_SIGMAS, *sums)
        weights = (OUTSIDE_WEIGHT, OUTSIDE_SIGMAS)
        cost += add_outside(view.field, view.origin, circles, CONTAINED, view.sigma, weights, *sums)
        contacts.append(Contact(*contact))
        count += len(view.pixels)
    return _System(information, gradient, tuple(contacts), cost, max(count, 1))


def focal_length(projection: Array) -> float:
    """The focal length in px of a projection (3, 4) whose third row gives depths in m."""
    a, b = projection[0, :3], projection[2, :3]
    dot = float(a @ b)
    return math.sqrt(max(float(a @ a) * float(b @ b) - dot * dot, 0.0))


def _step(pose: HandPose, system: _System, prior: Prior) -> Array:
    """The Gauss-Newton step (16,), shortened where it would turn a joint too far at once."""
    pull = system.gradient + prior.information @ _strain(pose, prior)
    step = np.linalg.solve(system.information + prior.information, -pull).astype(np.float64)
    return step * min(1.0, MAX_TURN / max(float(np.abs(step[3:]).max()), 1e-9))


def _strain(pose: HandPose, prior: Prior) -> Array:
    """How far a hand is from what was known of it, (16,)."""
    strain = np.zeros(STATE)
    strain[:3] = pose.wrist - prior.wrist
    strain[POSE:] = pose.posture - prior.posture
    if prior.near is not None:
        strain[3:POSE] = rotation_vector(pose.rotation @ prior.near.rotation.T)
    return strain


def rotation_vector(rotation: Array) -> Array:
    """The vector (3,) of a rotation (3, 3) by less than half a turn."""
    r = rotation
    v = 0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    sine = math.sqrt(float(v @ v))
    return v * (math.atan2(sine, 0.5 * (float(np.trace(r)) - 1)) / sine) if sine > 1e-9 else v
