"""What inverse kinematics answers: a posture with its stance, or why there is none."""

from dataclasses import dataclass
from typing import NamedTuple

from common.geometry import Array
from remote_site.reasons import Reason


class Stance(NamedTuple):
    """Which of the eight: shoulder to the front or back, elbow, wrist turned one way (+1) or the other (-1)."""

    shoulder: int
    elbow: int
    wrist: int


@dataclass(frozen=True, slots=True)
class Solution:
    """Joint positions (6,) in rad that reach the target, and their stance.

    The position of the tool is always reached, but for a millimetre where `held` says so; `lost_rad` of its
    orientation is not, while joint 4 is damped or too slow, or joint 4 or 6 at its limit.
    """

    q: Array
    stance: Stance
    held: bool = False
    lost_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class Unreachable:
    """There is no acceptable solution, and why."""

    reason: Reason
