"""Finds a hand whose pose is unknown: starts all around the line from the wrist to the far end of the outline."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import Fit, HandView, Prior, fit_hand
from local_site.tracking.silhouette.hand_model.placement import HandPose, Person, place, turned
from local_site.tracking.silhouette.hand_model.skeleton import MIDDLE_TIP

FIRST_ITERATIONS = 4
LAST_ITERATIONS = 8
COARSE_STEP = 2
TILTS = (-0.35, 0.0, 0.35)


def search_hand(views: Sequence[HandView], far_end: Array, prior: Prior, person: Person, rolls: int, kept: int) -> Fit:
    """The best fit from `rolls` starts, each tilted a little to and fro, with the middle finger's tip towards `far_end`
    (3,) in m.

    All starts are improved a little on some of the outline's pixels, the best `kept` of them fully.
    """
    coarse = [replace(view, pixels=np.ascontiguousarray(view.pixels[::COARSE_STEP])) for view in views]
    starts = _starts(far_end, prior, person, rolls)
    rough = sorted((fit_hand(coarse, start, prior, person, FIRST_ITERATIONS) for start in starts), key=_cost)
    return min((fit_hand(views, fit.pose, prior, person, LAST_ITERATIONS) for fit in rough[:kept]), key=_cost)


def _starts(far_end: Array, prior: Prior, person: Person, rolls: int) -> list[HandPose]:
    towards = far_end - prior.wrist
    towards = towards / max(float(np.linalg.norm(towards)), 1e-9)
    local = place(HandPose(np.zeros(3), np.eye(3), prior.posture), person).centres[MIDDLE_TIP]
    aligned = _between(local / np.linalg.norm(local), towards)
    turns = [turned(2 * math.pi * k / rolls * towards) @ aligned for k in range(rolls)]
    tilts = [turned(np.array([0.0, tilt, 0.0])) for tilt in TILTS]
    return [HandPose(prior.wrist, turn @ tilt, prior.posture) for turn in turns for tilt in tilts]


def _between(first: Array, second: Array) -> Array:
    """The least rotation (3, 3) that takes one unit vector to another."""
    axis = np.cross(first, second)
    sine, cosine = float(np.linalg.norm(axis)), float(first @ second)
    if sine < 1e-9:
        across = np.eye(3)[int(np.argmin(np.abs(first)))]
        axis, sine = np.cross(first, across), float(np.linalg.norm(np.cross(first, across)))
        return np.eye(3) if cosine > 0 else turned(math.pi * axis / sine)
    return turned(axis / sine * math.atan2(sine, cosine))


def _cost(fit: Fit) -> float:
    return fit.cost
