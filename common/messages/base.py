"""Field types and base of all messages: SI units, the sender's monotonic nanoseconds, the protocol version."""

from typing import Annotated

import msgspec

PROTOCOL_VERSION = 17
SESSION_BITS = 32  # of the random number that a start of a site draws: five bytes on the wire
SINGLE = msgspec.Meta(extra={"sent_as": "single precision"})
IN_SIX_BYTES = msgspec.Meta(extra={"sent_as": "covariance"})
Vector3 = Annotated[tuple[float, float, float], SINGLE]
Quaternion = Annotated[tuple[float, float, float, float], SINGLE]
MOST_TEXT = 400  # characters
Text = Annotated[str, msgspec.Meta(max_length=MOST_TEXT)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=64)]
Count = Annotated[int, msgspec.Meta(ge=0, le=2**63 - 1)]
Difference = Annotated[int, msgspec.Meta(ge=-(2**63), le=2**63 - 1)]
Variance = Annotated[float, msgspec.Meta(ge=0)]
Covariance = Annotated[tuple[Variance, float, float, Variance, float, Variance], IN_SIX_BYTES]
MOST_JOINTS = 16
Joints = Annotated[tuple[float, ...], msgspec.Meta(max_length=MOST_JOINTS), SINGLE]


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of all messages; each is sent with the protocol version before its fields."""
