"""The outcome of validation: a hand sample is accepted, or rejected with the reason; pure."""

from dataclasses import dataclass

from common.geometry import Array
from common.messages.hand import HandArm
from remote_site.reasons import Reason


@dataclass(frozen=True, slots=True)
class Accepted:
    """A sample to follow: the hand's position (3,) in the operator frame in m, its orientation (3 x 3) if it shows one.

    The position is the wrist's or the palm's, as configured for the mapping.
    `born_ns` is its capture on our clock, the earliest it can be; the age counts from there. The orientation is None
    while a fingertip is missing, inferred or poorly known, the hand is open or turns too fast to be meant.
    `speed` is the fraction of full speed that the wrist's covariance allows.
    """

    sample: HandArm
    position: Array
    operator_R_hand: Array | None
    born_ns: int
    new_session: bool
    speed: float = 1.0


@dataclass(frozen=True, slots=True)
class Rejected:
    """A sample not to follow; `hand_lost` when the tracker lost the hand, `latch` when the engagement must end.

    `held` is the operator's intent in it, None where the sample is not to be believed at all.
    """

    reason: Reason
    hand_lost: bool = False
    latch: bool = False
    new_session: bool = False
    held: bool | None = None
