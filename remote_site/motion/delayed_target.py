"""A target of the tool that goes along the hand's path, late, while the joints cannot follow it; pure."""

import math
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits
from remote_site.motion.catch_up import BOUNDS
from remote_site.motion.target_path import TargetPath

BEGIN_M, AVERAGED_S = 0.005, 0.05  # a tool that is so far off on average is left behind: noise takes it less far
NEAR_M, FAR_M = 0.002, 0.006  # the target waits for a tool that is off it: the more, the farther
BENT, BRAKED, HARDEST = 0.5, 0.6, 0.72  # of the joints' accelerations: for bends, to change the pace, to brake
CATCH_UP, MOST_PACE = 2.0, 5.0  # times as fast as after a hold: the hand is there, and sees it
RESTS, NEARER_M, HELD_S = 0.03, 0.0002, 0.3  # a pace at which the target waits; an arm that comes no nearer, so long
LONGEST_S = 5.0  # of the path: with more left, the target goes straight to the hand
SLOW, SLOWEST_PACE = 1e-9, 0.02


@dataclass(frozen=True, slots=True)
class Followed:
    """How an arm follows: how fast its joints (n,) move, how fast they would for the target's own motion, rad/s, and
    how far its tool is off (3,) in m."""

    dq: Array
    asked: Array
    off: Array


class DelayedTarget:
    """The target at the hand's pace, or at the pace that all joints can follow together.

    Each joint by itself would take the tool off its path by decimetres. The pace is 1 where time on the path passes as
    it does for the hand; `delay_s` is how long ago the hand was where the target is. The pace that joints can have is
    bounded by their speeds, and by their accelerations: with u = dq/ds at pace 1, the joints' acceleration is
    p' u + p² du/ds. As a stretched elbow comes nearer, du/ds grows sooner than u, so that the target slows in time.
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        self.path, self._limits, self._dt = TargetPath(dt), limits, dt
        self.reset()

    def reset(self) -> None:
        """Be where the hand is, at rest; forget its path."""
        self.path.clear()
        self.delay_s, self.pace = 0.0, 1.0
        self._held_s, self._least_m, self._gave_up = 0.0, math.inf, False
        self._asked: Array | None = None
        self._off = np.zeros(3)

    def advance(self, arm: Followed, speed: float, rate: Array, *, barred: bool) -> None:
        """Choose the pace for this tick, for an arm at a fraction of full speed and a path with this rate (6,).

        An arm that is `barred` from its path by an obstacle follows the hand itself.
        """
        self._off += self._dt / AVERAGED_S * (arm.off - self._off)
        wanted = self._wanted(arm, speed, rate)
        moved = np.minimum(np.abs(arm.asked), self._limits.velocity / max(self.pace, SLOWEST_PACE))
        steepest = float(np.min(self._limits.acceleration / np.maximum(moved, SLOW)))
        slowest = min(self.pace, self._pace_of(arm)) - HARDEST * steepest * self._dt
        self.pace = max(min(max(wanted, slowest), self.pace + BRAKED * steepest * self._dt), 0.0)
        self._asked = arm.asked
        self.delay_s += (1.0 - self.pace) * self._dt
        if barred or self._gave_up or self.delay_s > LONGEST_S or self.delay_s <= 0.0:
            self.delay_s, self.pace = 0.0, 1.0

    def _pace_of(self, arm: Followed) -> float:
        """The pace at which the joints are on their way: less than the target's while they still get there."""
        dq, asked = arm.dq / self._limits.velocity, arm.asked / self._limits.velocity
        return float(dq @ asked) / max(float(asked @ asked), SLOW)

    def _wanted(self, arm: Followed, speed: float, rate: Array) -> float:
        """The pace that the arm can follow; the hand's own where it is not left behind."""
        fastest = TARGET_SPEED * speed * self._limits.velocity
        followable = float(np.min(fastest / np.maximum(np.abs(arm.asked), SLOW)))
        if self.delay_s == 0.0 and followable >= 1.0 and math.hypot(*self._off) < BEGIN_M:
            return 1.0
        return min(_catching_up(rate), followable, self._at_a_bend(arm.asked)) * self._near(arm)

    def _at_a_bend(self, asked: Array) -> float:
        """The pace at which p² du/ds takes its part of the joints' accelerations."""
        if self._asked is None or self.pace < SLOWEST_PACE:
            return MOST_PACE
        bend = np.abs(asked - self._asked) / (self._dt * self.pace)
        return math.sqrt(float(np.min(BENT * self._limits.acceleration / np.maximum(bend, SLOW))))

    def _near(self, arm: Followed) -> float:
        """Rate how near the tool is to the target: 1 where it goes on as it can, 0 where it waits.

        It waits in vain for an arm that comes no nearer, at the end of its reach or of a joint. From there the arm
        follows the hand itself, until it is near again.
        """
        off_m = math.hypot(*arm.off)
        if self.pace >= RESTS or off_m < self._least_m - NEARER_M:
            self._least_m, self._held_s = off_m, 0.0
        else:
            self._held_s += self._dt
        self._gave_up = self._held_s > HELD_S or (self._gave_up and off_m >= FAR_M)
        return 1.0 if self._gave_up else min(max((FAR_M - off_m) / (FAR_M - NEAR_M), 0.0), 1.0)


def _catching_up(rate: Array) -> float:
    """The pace that exceeds the hand's own, at a rate (6,) of its path, by no more than what may be caught up."""
    own = math.hypot(*rate[:3]), math.hypot(*rate[3:])
    allowed = (1.0 + CATCH_UP * more / max(moves, SLOW) for moves, more in zip(own, BOUNDS, strict=True))
    return min(MOST_PACE, *allowed)
