"""Finds a hand whose pose is unknown: starts all around the line from the wrist to the far end of the outline."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import HandFit, HandView, Prior, fit_hand
from local_site.tracking.silhouette.hand_model.placement import HandPose, Person, place, turned
from local_site.tracking.silhouette.hand_model.skeleton import MIDDLE_TIP

FIRST_ITERATIONS = 6
LAST_ITERATIONS = 8
COARSE_STEP = 2
PARALLEL = 1e-6


@dataclass(frozen=True, slots=True)
class Effort:
    """How widely to search: `rolls` starts around the line to the far end, turned by `offset` of a step, each tilted by
    `tilts` in rad; the best `kept` are improved fully."""

    rolls: int
    kept: int
    tilts: tuple[float, ...] = (-0.35, 0.0, 0.35)
    offset: float = 0.0


def search_hand(views: Sequence[HandView], far_end: Array, prior: Prior, person: Person, effort: Effort) -> HandFit:
    """The best fit from starts with the middle finger's tip towards `far_end` (3,) in m.

    All starts are improved a little on some of the outline's pixels, the best fully on all.
    """
    coarse = [replace(view, pixels=np.ascontiguousarray(view.pixels[::COARSE_STEP])) for view in views]
    starts = _starts(far_end, prior, person, effort)
    rough = sorted((fit_hand(coarse, start, prior, person, FIRST_ITERATIONS) for start in starts), key=_cost)
    return min((fit_hand(views, fit.pose, prior, person, LAST_ITERATIONS) for fit in rough[: effort.kept]), key=_cost)


def _starts(far_end: Array, prior: Prior, person: Person, effort: Effort) -> list[HandPose]:
    local = place(HandPose(np.zeros(3), np.eye(3), prior.posture), person).centres[MIDDLE_TIP]
    ahead = _frame(far_end - prior.wrist, -person.to_elbow)
    aligned = ahead @ _frame(local, np.array([0.0, 0.0, 1.0])).T
    angles = [2 * math.pi * (k + effort.offset) / effort.rolls for k in range(effort.rolls)]
    turns = [turned(angle * ahead[:, 0]) @ aligned for angle in angles]
    tilts = [turned(np.array([0.0, tilt, 0.0])) for tilt in effort.tilts]
    return [HandPose(prior.wrist, turn @ tilt, prior.posture) for turn in turns for tilt in tilts]


def _frame(first: Array, second: Array) -> Array:
    """The rotation (3, 3) with its first axis along one vector (3,) and the second as near to another as it can be."""
    x = first / max(float(np.linalg.norm(first)), 1e-9)
    y = second - x * float(x @ second)
    if float(np.linalg.norm(y)) < PARALLEL:
        y = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))])
    y = y / float(np.linalg.norm(y))
    return np.column_stack([x, y, np.cross(x, y)])


def _cost(fit: HandFit) -> float:
    return fit.cost
