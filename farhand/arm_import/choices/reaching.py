"""Postures for poses of the tool, found as the control cycle finds them: by its solver, step by step; pure."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from remote_site.kinematics.config import SingularityConfig, SolverConfig
from remote_site.kinematics.dexterity import Dexterity
from remote_site.kinematics.differential import DifferentialInverse, Move
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.safety.collision import CollisionModel

STEP_S = 0.02
MOST_STEPS = 200
SOLVER = SolverConfig(posture_gain_s=2.0)
REACHED_M, REACHED_RAD = 1e-3, 0.01
QUICK = 6.0, 1e4, 1e6  # rad/s, rad/s², rad/s³: of joints that only search
SINGULARITY = SingularityConfig()
WORST_CONDITION = 30.0  # of the Jacobian: half of that from which lost directions are damped
REACH_POSTURES, TOUCH_POSTURES = 2000, 300
PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53)


@dataclass(frozen=True, slots=True)
class PostureQuality:
    """The quality of a posture: the Jacobian's condition number, least distance in m, the room to a limit in rad."""

    condition: float
    distance_m: float
    room_rad: float


class Reaching:
    """Finds postures of one arm in its cell; deterministic."""

    def __init__(self, model: ArmModel, limits: JointLimits, collision: CollisionModel) -> None:
        self.model, self.limits, self.collision = model, limits, collision
        n = len(limits.names)
        velocity, acceleration, jerk = (np.full(n, value) for value in QUICK)
        self._quick = replace(limits, velocity=velocity, acceleration=acceleration, jerk=jerk)
        self._dexterity = Dexterity(model, SINGULARITY)

    def towards(self, base_T_tool: Array, q: Array, posture: Array) -> Array | None:
        """The posture (n,) in rad that reaches a pose (4 x 4) from one at `q` in steps; None where it does not.

        What is free of seven axes tends to `posture` (n,).
        """
        solver = DifferentialInverse(self.model, self._quick, SOLVER, SINGULARITY, posture)
        move, still = replace(Move.at_rest(q), off_m=math.inf, off_rad=math.inf), np.zeros(6)
        for _ in range(MOST_STEPS):
            move = solver.step(move, base_T_tool, still, 1.0, STEP_S, None)
            if move.off_m < REACHED_M and move.off_rad < REACHED_RAD:
                return move.q
        return None

    def quality(self, q: Array) -> PostureQuality:
        """Of a posture (n,) in rad."""
        room = np.minimum(q - self.limits.lower, self.limits.upper - q)
        return PostureQuality(self._dexterity.condition(q), self.collision.distance(q), float(room.min()))

    @property
    def middle(self) -> Array:
        """The posture (n,) in rad in the middle of all ranges."""
        middle: Array = (self.limits.lower + self.limits.upper) / 2
        return middle

    def postures(self, count: int) -> Iterator[Array]:
        """Postures (n,) in rad all over the joints' ranges, of a joint that turns more than once over its middle."""
        lower = np.maximum(self.limits.lower, -math.pi)
        upper = np.minimum(self.limits.upper, math.pi)
        spread = np.outer(np.arange(1, count + 1), np.sqrt(PRIMES[: len(lower)])) % 1.0
        yield from lower + (0.05 + 0.9 * spread) * (upper - lower)


def reach_of(reaching: Reaching) -> float:
    """Compute how far from the base's axis the tool centre point comes, m."""
    places = [reaching.model.position(q) for q in reaching.postures(REACH_POSTURES)]
    return max(math.hypot(float(place[0]), float(place[1])) for place in places)


def touching(reaching: Reaching) -> dict[tuple[str, str], float]:
    """Of each pair of bodies by name the fraction of all postures in which they are too near to each other."""
    collision = reaching.collision
    distances = np.array([collision.distances(q) for q in reaching.postures(TOUCH_POSTURES)])
    near: dict[tuple[str, str], list[NDArray[np.bool_]]] = {}
    for k in range(len(collision.levers)):
        near.setdefault(collision.names(k), []).append(distances[:, k] < collision.margin)
    return {names: float(np.any(found, axis=0).mean()) for names, found in near.items()}
