"""Field types and base of all messages: SI units, the sender's monotonic nanoseconds, the protocol version."""

from typing import Annotated

import msgspec

PROTOCOL_VERSION = 7
Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Text = Annotated[str, msgspec.Meta(max_length=400)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=64)]
Count = Annotated[int, msgspec.Meta(ge=0, le=2**63 - 1)]
Difference = Annotated[int, msgspec.Meta(ge=-(2**63), le=2**63 - 1)]
Variance = Annotated[float, msgspec.Meta(ge=0)]
Covariance = tuple[Variance, float, float, Variance, float, Variance]
Joints = Annotated[tuple[float, ...], msgspec.Meta(max_length=16)]


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of all messages: every one carries the protocol version."""

    version: int = PROTOCOL_VERSION
