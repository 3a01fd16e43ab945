"""Whether a fit is to be believed, and how sure its points are: report, never guess."""

from enum import StrEnum

import numpy as np

from common.geometry import Array, skew
from common.messages import TrackingStatus
from local_site.tracking.monocular.equations import condition, information
from local_site.tracking.monocular.estimator import Fit
from local_site.tracking.reasons import sentence

LEAST_POINTS = 100
WORST_CONDITION = 1e4
LEAST_NEAR, DOUBTED_NEAR = 0.75, 0.9
MOST_SCALED = 3.0
MAX_SIGMA_M, DOUBTED_SIGMA_M = 0.015, 0.006
# Neighbouring points share their errors, so that some tell as much as one; what was learned at a later pose is off with it.
ALIKE = 4.0
LEARNED_SIGMA_M = 3e-4


class Refusal(StrEnum):
    """A reason by name; its value is the sentence for people."""

    OUT_OF_VIEW = "the arm is out of the picture"
    FEW_POINTS = "fewer than 100 points of a link are in view: turn the arm, or give it light"
    ILL_CONDITIONED = "what is in view leaves the arm's motion open"
    NOT_FINITE = "the motion cannot be computed from this picture"
    UNCONVERGED = "the differences to the picture do not come to rest"
    UNLIKE = "the picture does not look like the arm as it was learned"
    HIDDEN = "a part of the arm is hidden, or does not look as it was learned"
    UNSURE = "the arm's place is not sure enough"


def judged(fit: Fit | None) -> tuple[TrackingStatus, str]:
    """Status and reason of a fit; None stands for an arm out of the picture."""
    refusal = _refusal(fit)
    if fit is None or refusal is not None:
        return TrackingStatus.LOST, refusal or Refusal.OUT_OF_VIEW
    doubts = []
    if not fit.converged:
        doubts.append(Refusal.UNCONVERGED)
    if fit.equations.near.min() < DOUBTED_NEAR:
        doubts.append(Refusal.HIDDEN)
    if _sigma(fit) > DOUBTED_SIGMA_M:
        doubts.append(Refusal.UNSURE)
    return (TrackingStatus.DEGRADED if doubts else TrackingStatus.TRACKED), sentence(doubts)


def _refusal(fit: Fit | None) -> Refusal | None:
    if fit is None:
        return Refusal.OUT_OF_VIEW
    equations = fit.equations
    if not fit.finite or not np.all(np.isfinite(equations.matrix)):
        return Refusal.NOT_FINITE
    if equations.points.min() < LEAST_POINTS:
        return Refusal.FEW_POINTS
    if condition(information(equations.matrix)) > WORST_CONDITION:
        return Refusal.ILL_CONDITIONED
    if equations.near.min() < LEAST_NEAR or (not fit.converged and equations.scaled.max() > MOST_SCALED):
        return Refusal.UNLIKE
    return Refusal.UNSURE if _sigma(fit) > MAX_SIGMA_M else None


def covariances(fit: Fit, on_forearm: dict[str, Array]) -> dict[str, Array]:
    """Covariances (3, 3) in m² of the elbow and of named points of the forearm's frame (3,), in the camera's frame.

    From the normal matrix, with what the points miss the picture by, and for errors that points share.
    """
    pose, share = fit.state.pose, ALIKE * max(float(fit.equations.scaled.max()), 1.0)
    spread: Array = share * np.asarray(np.linalg.inv(information(fit.equations.matrix)), dtype=np.float64)
    result = {"elbow": _carried(spread, pose.elbow - pose.shoulder, np.zeros(3))}
    for name, point in on_forearm.items():
        result[name] = _carried(spread, pose.elbow - pose.shoulder, pose.forearm @ point)
    return result


def _carried(spread: Array, upper: Array, lower: Array) -> Array:
    """The covariance of a point that both links carry: translation, then what the turns do to their arms (3,)."""
    by = np.hstack([np.eye(3), -skew(upper), -skew(lower)])
    result: Array = by @ spread @ by.T + LEARNED_SIGMA_M**2 * np.eye(3)
    return result


def _sigma(fit: Fit) -> float:
    """The rms length of the wrist's error, m."""
    far = np.array([0.0, 0.0, fit.state.pose.upper_arm_length])
    return float(np.sqrt(np.trace(covariances(fit, {"end": far})["end"])))
