"""Dexterity: how close a posture is to a singularity, and how much slower the arm moves towards a more singular one."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from common.geometry import Array
from remote_site.kinematics.config import SingularityConfig
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code, Reason, reason

TINY = 1e-12


@dataclass(frozen=True, slots=True)
class Slowing:
    """The fraction of the speed that is left, and why it is less than 1."""

    fraction: float
    reason: Reason | None


FULL = Slowing(1.0, None)


class Dexterity:
    """Slows motion into a singular posture in proportion to the condition number; motion out of it is never slowed."""

    def __init__(self, model: ArmModel, config: SingularityConfig) -> None:
        self._model = model
        self._config = config
        self._weights = task_weights(config.radius_m)

    def condition(self, q: Array) -> float:
        """The condition number of the Jacobian, turns weighted by `radius_m`; inf where it is singular."""
        _, sigma, _, failed = lapack.dgesdd(self._weights * self._model.jacobian(q), compute_uv=0)
        least = float(sigma[-1])
        return float(sigma[0]) / least if not failed and least > TINY else math.inf

    def slowing(self, q: Array, q_target: Array) -> Slowing:
        """For an arm at `q` (n,) rad that moves towards `q_target` (n,) rad, both finite."""
        condition = self.condition(q)
        begins = self._config.slow_condition
        if condition <= begins or self.condition(q_target) < condition:
            return FULL
        fraction = max(begins / condition, self._config.slowest)
        return Slowing(fraction, reason(Code.SINGULAR, condition=condition, fraction=fraction))


def task_weights(radius_m: float) -> Array:
    """The weight (6, 1) of each row of a Jacobian (6 x n): 1 for translations, `radius_m` in m for rotations."""
    return np.array([1.0, 1.0, 1.0, radius_m, radius_m, radius_m])[:, None]
