"""Finds a hand of unknown pose, and distinguishes right from left hands, by fits from many starts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import HandFit, HandView, Prior, fit_hand
from local_site.tracking.silhouette.hand_model.habits import Habits, LimbEvidence
from local_site.tracking.silhouette.hand_model.skeleton import MIDDLE_TIP, HandPose, Person, hand_spheres, turned

FIRST_ITERATIONS = 6
LAST_ITERATIONS = 8
COARSE_STEP = 2
PARALLEL = 1e-6
CLEARLY_WORSE = 1.2


@dataclass(frozen=True, slots=True)
class Effort:
    """The extent of a search: `rolls` starts around the line to the far end, turned by `offset` of a step, each tilted
    by `tilts` in rad; the best `kept` are fitted fully."""

    rolls: int
    kept: int
    tilts: tuple[float, ...] = (-0.35, 0.0, 0.35)
    offset: float = 0.0


HANDEDNESS_EFFORT = Effort(rolls=12, kept=4)


def search_hand(views: Sequence[HandView], far_end: Array, prior: Prior, person: Person, effort: Effort) -> HandFit:
    """The best fit from starts with the middle finger's tip towards `far_end` (3,) in m.

    All starts are fitted for a few iterations on some of the outline's pixels, the best fully on all.
    """
    coarse = [view._replace(pixels=np.ascontiguousarray(view.pixels[::COARSE_STEP])) for view in views]
    starts = _starts(far_end, prior, person, effort)
    rough = sorted((fit_hand(coarse, start, prior, person, FIRST_ITERATIONS) for start in starts), key=_cost)
    return min((fit_hand(views, fit.pose, prior, person, LAST_ITERATIONS) for fit in rough[: effort.kept]), key=_cost)


def looks_like_the_other_arm(views: Sequence[HandView], arm: LimbEvidence, right_arm: bool) -> bool:
    """Whether an average hand of the other arm explains the outlines clearly better than one of this arm.

    In exchanged and mirrored pictures a right arm looks like a left one. Both are searched for with the same effort.
    Thumb and index look alike on both arms: the curled fingers on the palm's side decide.
    """
    prior = arm.prior(Habits().closed)
    own, other = (
        search_hand(views, arm.far_end, prior, arm.person(side), HANDEDNESS_EFFORT).cost
        for side in (right_arm, not right_arm)
    )
    return own > CLEARLY_WORSE * other


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


def _cost(fit: HandFit) -> float:
    return fit.cost
