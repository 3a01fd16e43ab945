"""Keeps the joints' target away from what the arm must not touch: slower when nearer, never through it, always back."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from remote_site.safety.collision import CollisionModel, Near
from remote_site.safety.config import CollisionConfig
from remote_site.safety.status import Code, Reason, reason

SPARE = 2e-3  # m beyond the margin: the guard is not asked to stop what the shield has let through
BRAKING = 4.0  # 1/s: the target approaches by no more than this share of the room per second
SWEEPS = 20  # of bringing the target onto the right side of all that is near; else it stays
TINY = 1e-7  # m


@dataclass(frozen=True, slots=True)
class Shielded:
    """The target that is left: joints (n,) in rad and rad/s, the share of the speed, and why it was changed."""

    q: Array
    dq: Array
    speed: float
    reason: Reason | None


class Shield:
    """Turns a joint target aside before the guard has to refuse it, so that the arm slides along what it meets.

    Every near pair allows motion on one side of a plane in joint space only; away from it, nothing is slowed.
    """

    def __init__(self, collision: CollisionModel, config: CollisionConfig) -> None:
        self._collision = collision
        self._config = config
        self._stops_at = config.margin_m + SPARE

    def turn_aside(self, q: Array, q_target: Array, dq_target: Array) -> Shielded:
        """The target for an arm at `q` (n,) rad whose target (n,) rad moves with (n,) rad/s."""
        if self._collision.farther_than(q, self._config.slow_m):
            return Shielded(q_target, dq_target, 1.0, None)
        near = [pair for pair in self._collision.nearer_than(q, self._config.slow_m) if pair.gradient.any()]
        ahead = q_target - q
        speed = min((self._share(pair) for pair in near if pair.gradient @ ahead < 0.0), default=1.0)
        room = [max(pair.distance - self._stops_at, 0.0) for pair in near]
        turned = _beside(ahead, near, room)
        slowed = _beside(dq_target, near, [BRAKING * metres for metres in room])
        why = self._reason(near) if turned is not ahead else None
        return Shielded(q + turned, slowed, speed, why)

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
