"""Keeps the arm away from what it must not touch: slower when nearer, along it instead of through it, always back."""

from dataclasses import dataclass

import daqp
import numpy as np

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.collision import CollisionModel, Near
from remote_site.safety.config import CollisionConfig

SPARE = 4e-3  # m beyond the margin: the joints stop one after the other, and the guard judges that way to rest
BRAKING = 4.0  # 1/s: nothing approaches by more than this share of the room per second
AHEAD_S = 0.03  # how far ahead an acceleration is judged by the speed it leads to
SWEEPS = 20  # of bringing the target onto the right side of all that is near; else it stays
TINY = 1e-7  # m
SOLVED = 1


@dataclass(frozen=True, slots=True)
class Shielded:
    """The target that is left: joints (n,) in rad and rad/s, the share of the speed, what is near, why it changed."""

    q: Array
    dq: Array
    speed: float
    near: tuple[Near, ...]
    reason: Reason | None


class CollisionAvoidance:
    """Turns a joint target aside before the guard has to refuse it, so that the arm slides along what it meets.

    Every near pair allows motion on one side of a plane in joint space only; away from it, nothing is slowed.
    """

    def __init__(self, collision: CollisionModel, config: CollisionConfig, limits: JointLimits, dt: float) -> None:
        self._collision = collision
        self._config = config
        self._limits = limits
        self._dt = dt
        self._stops_at = config.margin_m + SPARE
        self._identity, self._every = np.eye(len(limits.names)), np.zeros(len(limits.names), dtype=np.int32)

    def turn_aside(self, q: Array, q_target: Array, dq_target: Array) -> Shielded:
        """The target for an arm at `q` (n,) rad whose target (n,) rad moves with (n,) rad/s."""
        near = [pair for pair in self._collision.nearer_than(q, self._config.slow_m) if pair.gradient.any()]
        if not near:
            return Shielded(q_target, dq_target, 1.0, (), None)
        ahead = q_target - q
        speed = min((self._share(pair) for pair in near if pair.gradient @ ahead < 0.0), default=1.0)
        room = [self._room(pair) for pair in near]
        turned = _beside(ahead, near, room)
        slowed = _beside(dq_target, near, [BRAKING * metres for metres in room])
        why = self._reason(near) if turned is not ahead else None
        return Shielded(q + turned, slowed, speed, tuple(near), why)

    def temper(self, proposed: JointMotion, sent: JointMotion, near: tuple[Near, ...]) -> JointMotion | None:
        """The motion nearest to the proposed one that approaches nothing too fast; None if there is none.

        The joints' own ways to a target take them through what their common way would avoid.
        """
        dt, limits = self._dt, self._limits
        rows = np.array([pair.gradient for pair in near])
        least = np.array([-BRAKING * self._room(pair) for pair in near])
        if (rows @ (proposed.dq + AHEAD_S * proposed.ddq) >= least).all():
            return proposed
        # v = sent.dq + dt (sent.ddq + a) / 2 for the acceleration a at the tick's end, with constant jerk
        coast = sent.dq + dt / 2 * sent.ddq
        lowest = np.concatenate(
            [np.maximum(sent.ddq - dt * limits.jerk, -limits.acceleration), (least - rows @ coast) / (AHEAD_S + dt / 2)]
        )
        highest = np.concatenate(
            [np.minimum(sent.ddq + dt * limits.jerk, limits.acceleration), np.full(len(near), np.inf)]
        )
        sense = np.concatenate([self._every, np.zeros(len(near), dtype=np.int32)])
        ddq, _, status, _ = daqp.solve(self._identity, -proposed.ddq, rows, highest, lowest, sense)
        if status != SOLVED:
            return None
        jerk = (ddq - sent.ddq) / dt
        q = sent.q + dt * sent.dq + dt**2 / 2 * sent.ddq + dt**3 / 6 * jerk
        return JointMotion(q, coast + dt / 2 * ddq, ddq)

    def _room(self, pair: Near) -> float:
        return max(pair.distance - self._stops_at, 0.0)

    def _share(self, pair: Near) -> float:
        config = self._config
        share = (pair.distance - config.margin_m) / (config.slow_m - config.margin_m)
        return min(max(share, config.slowest), 1.0)

    @staticmethod
    def _reason(near: list[Near]) -> Reason:
        nearest = min(near, key=lambda pair: pair.distance)
        first, second = nearest.names
        return reason(Code.OBSTACLE, first=first, second=second, distance_mm=nearest.distance * 1e3)


def _beside(step: Array, near: list[Near], room: list[float]) -> Array:
    """The step (n,) without what would bring any pair nearer than it has room; the same array if there is nothing."""
    for _ in range(SWEEPS):
        changed = False
        for pair, metres in zip(near, room, strict=True):
            missing = -metres - float(pair.gradient @ step)
            if missing > TINY:
                step = step + pair.gradient * (missing / float(pair.gradient @ pair.gradient))
                changed = True
        if not changed:
            return step
    return np.zeros(len(step))
