"""Whether to accept a fit, and the covariance of its points."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from common.geometry import Array, skew
from common.messages.hand import TrackingStatus
from local_site.tracking.monocular.equations import condition, information
from local_site.tracking.monocular.estimator import MotionFit
from local_site.tracking.monocular.pose import ArmPose
from local_site.tracking.reasons import sentence

LEAST_POINTS = 100
WORST_CONDITION = 1e4
LEAST_NEAR, DOUBTED_NEAR = 0.75, 0.9
MOST_SCALED = 3.0
MAX_SIGMA_M, DOUBTED_SIGMA_M = 0.015, 0.006
# The errors of neighbouring points are correlated: several carry the information of one.
CORRELATED = 4.0
LEARNED_SIGMA_M = 3e-4  # along each axis, of points that were learned at an estimated pose


class Refusal(StrEnum):
    """A reason by name; its value is the sentence for people."""

    OUT_OF_VIEW = "the arm is out of the picture"
    FEW_POINTS = "fewer than 100 points of a link are in view: turn the arm, or give it light"
    ILL_CONDITIONED = "the visible points do not determine the arm's motion"
    NOT_FINITE = "the motion cannot be computed from this picture"
    UNCONVERGED = "the fit to the picture does not converge"
    UNLIKE = "the picture does not look like the arm as it was learned"
    HIDDEN = "a part of the arm is hidden, or does not look as it was learned"
    UNSURE = "the arm's position is too uncertain"


@dataclass(frozen=True, slots=True)
class Judgement:
    """The verdict on a fit: status, reason, and the covariance (9, 9) of its motions, None if the arm is lost."""

    status: TrackingStatus
    reason: str
    spread: Array | None = None


def judged(fit: MotionFit | None) -> Judgement:
    """The verdict on a fit; None is an arm out of the picture."""
    if fit is None:
        return Judgement(TrackingStatus.LOST, Refusal.OUT_OF_VIEW)
    refusal = _refusal(fit)
    if refusal is not None:
        return Judgement(TrackingStatus.LOST, refusal)
    inverse = np.asarray(np.linalg.inv(information(fit.equations.matrix)), dtype=np.float64)
    spread: Array = CORRELATED * max(float(fit.equations.scaled.max()), 1.0) * inverse
    reach = np.array([0.0, 0.0, fit.state.pose.upper_arm_length])
    sigma_m = math.sqrt(float(np.trace(covariances(fit.state.pose, spread, {"end": reach})["end"])))
    if sigma_m > MAX_SIGMA_M:
        return Judgement(TrackingStatus.LOST, Refusal.UNSURE)
    doubts = [
        doubt
        for doubt, is_so in (
            (Refusal.UNCONVERGED, not fit.converged),
            (Refusal.HIDDEN, fit.equations.near.min() < DOUBTED_NEAR),
            (Refusal.UNSURE, sigma_m > DOUBTED_SIGMA_M),
        )
        if is_so
    ]
    return Judgement(TrackingStatus.DEGRADED if doubts else TrackingStatus.TRACKED, sentence(doubts), spread)


def _refusal(fit: MotionFit) -> Refusal | None:
    equations = fit.equations
    if equations.points.min() < LEAST_POINTS:
        return Refusal.FEW_POINTS
    if not fit.finite or not np.all(np.isfinite(equations.matrix)):
        return Refusal.NOT_FINITE
    if condition(information(equations.matrix)) > WORST_CONDITION:
        return Refusal.ILL_CONDITIONED
    if equations.near.min() < LEAST_NEAR or (not fit.converged and equations.scaled.max() > MOST_SCALED):
        return Refusal.UNLIKE
    return None


def covariances(pose: ArmPose, spread: Array, on_forearm: Mapping[str, Array]) -> dict[str, Array]:
    """Covariances (3, 3) in m² of the elbow and of named points of the forearm's frame (3,), in the camera's frame.

    `spread` (9, 9) is the covariance of the motions. A point carried by both links moves by the translation and by
    each rotation's lever arm (3,).
    """
    upper = pose.elbow - pose.shoulder
    arms = {"elbow": np.zeros(3)} | {name: pose.forearm @ point for name, point in on_forearm.items()}
    jacobians = {name: np.hstack([np.eye(3), -skew(upper), -skew(lower)]) for name, lower in arms.items()}
    return {name: by @ spread @ by.T + LEARNED_SIGMA_M**2 * np.eye(3) for name, by in jacobians.items()}
