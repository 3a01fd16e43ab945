"""The iterated maximum likelihood estimate of the arm's motion (sections 2.5 and 2.6): root, lower arm, and both."""

from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array
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
    step,
    summed,
)
from local_site.tracking.monocular.picture import PyramidLevel
from local_site.tracking.monocular.pose import ArmPose

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
