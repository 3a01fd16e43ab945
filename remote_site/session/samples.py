"""Hand samples as they arrive, and the outcome of validation: accepted, or rejected with the reason; pure."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from msgspec.structs import replace

from common.geometry import Array
from common.messages.base import Vector3
from common.messages.hand import HandArm
from remote_site.reasons import Reason

MOST_NS = 2**63 - 1  # that a message holds


class NamedSample(NamedTuple):
    """A hand sample as it arrived, and the operator whose key it came on."""

    operator: str
    sample: HandArm


def as_of_now(sample: HandArm, ahead_ns: int) -> HandArm:
    """The sample with the clocks' offset of now; `ahead_ns` is by how much steady time is ahead of our clock.

    What our clock was slewed by, or stood still in a suspend, since the offset was measured is taken off it. A sample
    whose numbers cannot be so has none.
    """
    clock = sample.clock
    if clock is None or clock.remote_ahead_ns is None:
        return sample
    since_ns = ahead_ns - clock.remote_ahead_ns
    offset_ns, measured_ns = clock.remote_minus_local_ns - since_ns, clock.measured_ns - since_ns
    if not (-MOST_NS <= offset_ns <= MOST_NS and 0 <= measured_ns <= MOST_NS):
        return replace(sample, clock=None)
    now = replace(clock, remote_minus_local_ns=offset_ns, measured_ns=measured_ns, remote_ahead_ns=ahead_ns)
    return replace(sample, clock=now)


@dataclass(frozen=True, slots=True)
class Accepted:
    """A sample to follow: the hand's position (3,) in the operator frame in m, its orientation (3 x 3) if it shows one.

    The position is the wrist's or the palm's, as configured for the mapping.
    `born_ns` is its capture on our clock, the earliest it can be; the age counts from there. The orientation is None
    while a fingertip is missing or poorly known, the hand is open or turns too fast to be meant.
    `speed` is the fraction of full speed that the position's covariance allows, `turn_rad_s` how fast the tool may turn
    about the hand's x, y and z. `elbow` is the operator's in m, None where it is known too poorly to be copied.
    """

    sample: HandArm
    position: Array
    operator_R_hand: Array | None
    born_ns: int
    new_session: bool
    speed: float = 1.0
    turn_rad_s: Vector3 = (math.inf, math.inf, math.inf)
    elbow: Vector3 | None = None

    @property
    def captured_ns(self) -> int:
        """Its capture on our clock, most likely: by the measured offset alone."""
        return self.born_ns + (self.sample.clock.uncertainty_ns if self.sample.clock is not None else 0)


@dataclass(frozen=True, slots=True)
class Rejected:
    """A sample not to follow; `hand_lost` when the tracker lost the hand, `latch` when the engagement must end.

    `sample` is None where not even its intent is to be believed.
    """

    reason: Reason
    hand_lost: bool = False
    latch: bool = False
    new_session: bool = False
    sample: HandArm | None = None
