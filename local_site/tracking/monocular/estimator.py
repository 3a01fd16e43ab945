"""The iterated maximum likelihood estimate of the arm's motion (sections 2.5 and 2.6): root, lower arm, and both.

Also whether to accept it, and the covariance of its points.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from common.geometry import Array, skew
from common.messages.hand import TrackingStatus
from local_site.tracking.monocular.arm_model import ArmPose
from local_site.tracking.monocular.equations import (
    ALL,
    FOREARM_LIGHT,
    FOREARM_TURN,
    LOWER,
    ROOT,
    TRANSLATION,
    UPPER_LIGHT,
    UPPER_TURN,
    Equations,
    Surface,
    combined,
    condition,
    information,
    step,
    summed,
)
from local_site.tracking.monocular.picture import PyramidLevel

HUBER = 1.5
HALVINGS = 3
FIRST_CHANGE = 0.3  # grey², while one link is fitted alone
RISE = 1e-3  # of the mean square: the gradients, and with them the weights, change slightly with every step


@dataclass(frozen=True, slots=True)
class EstimatorSetting:
    """The computing effort for a frame: points per link, the least change of the mean square in grey², iterations.

    With `both_first` the links are estimated one by one only if estimating both at once does not converge.
    """

    points: int
    least_change: float
    iterations: int
    both_first: bool = False


LIVE = EstimatorSetting(points=800, least_change=1e-2, iterations=10, both_first=True)
ACCURATE = EstimatorSetting(points=5000, least_change=1e-5, iterations=30)
COARSE = EstimatorSetting(points=200, least_change=1e-1, iterations=8)


@dataclass(frozen=True, slots=True)
class EstimatorState:
    """The estimated state: the pose, and the light (4,) on upper arm and forearm, level and gradient by the normal."""

    pose: ArmPose
    upper_light: Array
    forearm_light: Array

    @property
    def lights(self) -> tuple[Array, Array]:
        """The light on both links."""
        return self.upper_light, self.forearm_light

    def stepped(self, by: Array) -> "EstimatorState":
        """The state after a step (17,)."""
        pose = self.pose.moved(by[TRANSLATION], by[UPPER_TURN], by[FOREARM_TURN])
        return EstimatorState(pose, self.upper_light + by[UPPER_LIGHT], self.forearm_light + by[FOREARM_LIGHT])


@dataclass(frozen=True, slots=True)
class MotionFit:
    """A state with the equations there, whether its mean square has converged, and in how many iterations.

    `finite` is False if the next step had no solution.
    """

    state: EstimatorState
    equations: Equations
    converged: bool
    iterations: int
    finite: bool = True


@dataclass(frozen=True, slots=True)
class EstimatorScene:
    """The data of a fit: a level of the frame, both links' visible points, and the variances of section 2.3."""

    level: PyramidLevel
    upper: Surface
    forearm: Surface
    variances: Array

    def equations(self, state: EstimatorState, free: slice) -> Equations:
        """The equations of the links that the free unknowns belong to."""
        pose, level = state.pose, self.level
        uses_upper, uses_forearm = free.start == ALL.start, free.stop == ALL.stop
        upper = (pose.shoulder, pose.upper_arm, state.upper_light)
        forearm = (pose.elbow, pose.forearm, state.forearm_light)
        return combined(
            summed(self.upper, upper, level, self.variances, HUBER) if uses_upper else None,
            summed(self.forearm, forearm, level, self.variances, HUBER) if uses_forearm else None,
            pose.elbow - pose.shoulder,
        )


def fit_arm(scene: EstimatorScene, start: EstimatorState, setting: EstimatorSetting) -> MotionFit:
    """Fit the upper arm, the forearm, then both at once; or only both at once, if that converges."""
    if setting.both_first:
        direct = settled(scene, start, ALL, setting)
        if direct.converged:
            return direct
    first = replace(setting, least_change=max(setting.least_change, FIRST_CHANGE))
    root = settled(scene, start, ROOT, first)
    lower = settled(scene, root.state, LOWER, first)
    both = settled(scene, lower.state, ALL, setting)
    return replace(both, iterations=root.iterations + lower.iterations + both.iterations)


def settled(scene: EstimatorScene, start: EstimatorState, free: slice, setting: EstimatorSetting) -> MotionFit:
    """Gauss-Newton until the mean square changes by less than the setting's `least_change`.

    A step that increases the mean square is halved; if it still does after HALVINGS, the fit has not converged.
    """
    best = MotionFit(start, scene.equations(start, free), False, 0)
    by, halvings = step(best.equations, free), 0
    for iteration in range(1, setting.iterations + 1):
        if not np.all(np.isfinite(by)):
            return replace(best, finite=False)
        state = best.state.stepped(by)
        equations = scene.equations(state, free)
        change = best.equations.total - equations.total
        at_rest = -RISE * best.equations.total < change < setting.least_change
        if change < 0 and not at_rest:
            if halvings == HALVINGS:
                break
            by, halvings = 0.5 * by, halvings + 1
            continue
        best = MotionFit(state, equations, at_rest, iteration) if change > 0 else replace(best, converged=True)
        if at_rest:
            break
        by, halvings = step(equations, free), 0
    return best


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
    doubts = []
    if not fit.converged:
        doubts.append(Refusal.UNCONVERGED)
    if fit.equations.near.min() < DOUBTED_NEAR:
        doubts.append(Refusal.HIDDEN)
    if sigma_m > DOUBTED_SIGMA_M:
        doubts.append(Refusal.UNSURE)
    return Judgement(TrackingStatus.DEGRADED if doubts else TrackingStatus.TRACKED, "; ".join(doubts), spread)


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
