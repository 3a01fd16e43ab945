"""Collision avoidance: the arm slows near obstacles, slides along them instead of into them, and may always retreat."""

from dataclasses import dataclass

import daqp
import numpy as np

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.collision import ClosePair, CollisionModel
from remote_site.safety.config import CollisionConfig

SPARE = 4e-3  # m beyond the margin: the joints stop one after the other, and the guard judges that path
BRAKING = 4.0  # 1/s: nothing approaches by more than this fraction of the clearance per second
AHEAD_S = 0.03  # an acceleration is judged by the speed that it leads to after this time
SWEEPS = 20  # of projecting the target onto the allowed side of all close pairs; otherwise it stays
TINY = 1e-7  # m
SOLVED = 1


@dataclass(frozen=True, slots=True)
class AvoidingTarget:
    """The allowed target, the fraction of the speed, the close pairs, and why the target changed."""

    target: JointMotion
    speed: float
    close_pairs: tuple[ClosePair, ...]
    reason: Reason | None


class CollisionAvoidance:
    """Deflects a joint target before the guard has to refuse it, so that the arm slides along obstacles.

    Every close pair allows motion on one side of a plane in joint space only; motion away from it is not slowed.
    """

    def __init__(self, collision: CollisionModel, config: CollisionConfig, limits: JointLimits, dt: float) -> None:
        self._collision = collision
        self._config = config
        self._limits = limits
        self._dt = dt
        self._stops_at = config.margin_m + SPARE
        self._identity, self._every = np.eye(len(limits.names)), np.zeros(len(limits.names), dtype=np.int32)

    def turn_aside(self, q: Array, target: JointMotion) -> AvoidingTarget:
        """The allowed target for an arm at `q` (n,) rad; near obstacles it moves without acceleration."""
        close_pairs = [pair for pair in self._collision.pairs_within(q, self._config.slow_m) if pair.gradient.any()]
        if not close_pairs:
            return AvoidingTarget(target, 1.0, (), None)
        ahead = target.q - q
        speed = min((self._speed(pair) for pair in close_pairs if pair.gradient @ ahead < 0.0), default=1.0)
        clearances = [self._clearance(pair) for pair in close_pairs]
        turned = _beside(ahead, close_pairs, clearances)
        slowed = _beside(target.dq, close_pairs, [BRAKING * metres for metres in clearances])
        why = self._reason(close_pairs) if turned is not ahead else None
        moving = JointMotion(q + turned, slowed, np.zeros(len(q)))
        return AvoidingTarget(moving, speed, tuple(close_pairs), why)

    def temper(
        self, proposed: JointMotion, sent: JointMotion, close_pairs: tuple[ClosePair, ...]
    ) -> JointMotion | None:
        """The motion nearest to the proposed one that approaches nothing too fast; None if there is none.

        Joints that reach a target at different times may leave the path on which they avoid it together.
        """
        dt, limits = self._dt, self._limits
        rows = np.array([pair.gradient for pair in close_pairs])
        least = np.array([-BRAKING * self._clearance(pair) for pair in close_pairs])
        if (rows @ (proposed.dq + AHEAD_S * proposed.ddq) >= least).all():
            return proposed
        # v = sent.dq + dt (sent.ddq + a) / 2 for the acceleration a at the tick's end, with constant jerk
        coast = sent.dq + dt / 2 * sent.ddq
        lowest = np.concatenate(
            [np.maximum(sent.ddq - dt * limits.jerk, -limits.acceleration), (least - rows @ coast) / (AHEAD_S + dt / 2)]
        )
        highest = np.concatenate(
            [np.minimum(sent.ddq + dt * limits.jerk, limits.acceleration), np.full(len(close_pairs), np.inf)]
        )
        sense = np.concatenate([self._every, np.zeros(len(close_pairs), dtype=np.int32)])
        ddq, _, status, _ = daqp.solve(self._identity, -proposed.ddq, rows, highest, lowest, sense)
        if status != SOLVED:
            return None
        jerk = (ddq - sent.ddq) / dt
        q = sent.q + dt * sent.dq + dt**2 / 2 * sent.ddq + dt**3 / 6 * jerk
        return JointMotion(q, coast + dt / 2 * ddq, ddq)

    def _clearance(self, pair: ClosePair) -> float:
        return max(pair.distance - self._stops_at, 0.0)

    def _speed(self, pair: ClosePair) -> float:
        config = self._config
        fraction = (pair.distance - config.margin_m) / (config.slow_m - config.margin_m)
        return min(max(fraction, config.slowest), 1.0)

    @staticmethod
    def _reason(close_pairs: list[ClosePair]) -> Reason:
        nearest = min(close_pairs, key=lambda pair: pair.distance)
        first, second = nearest.names
        return reason(Code.OBSTACLE, first=first, second=second, distance_mm=nearest.distance * 1e3)


def _beside(step: Array, close_pairs: list[ClosePair], clearances: list[float]) -> Array:
    """The step (n,) without what would use up any pair's clearance in m; the same array if there is nothing."""
    for _ in range(SWEEPS):
        changed = False
        for pair, metres in zip(close_pairs, clearances, strict=True):
            missing = -metres - float(pair.gradient @ step)
            if missing > TINY:
                step = step + pair.gradient * (missing / float(pair.gradient @ pair.gradient))
                changed = True
        if not changed:
            return step
    return np.zeros(len(step))
