"""Pose of a simulated operator's hand, as another program of the operator's host leads it; not for the wire."""

from typing import Annotated

import msgspec

from common.messages.base import Count

Vector = tuple[float, float, float]


class LedPose(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The hand at an instant of this host's monotonic clock: from its start, in the operator frame.

    `offset` is the wrist's, m, `turn` a rotation vector, rad; `openings` counts how often the hand has begun to open.
    """

    t_ns: Count
    offset: Vector
    turn: Vector
    openness: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.0
    openings: Count = 0


# In one datagram at most.
LedPoses = Annotated[tuple[LedPose, ...], msgspec.Meta(max_length=64)]
