"""The parameters of engagement and lease."""

from enum import StrEnum
from typing import Annotated

import msgspec
from msgspec import Meta


class EngagementMode(StrEnum):
    """What makes the arm follow once all is ready."""

    AUTOMATIC = "automatic"
    ON_REQUEST = "on_request"
    HOLD_TO_RUN = "hold_to_run"
    PEDAL = "pedal"


class EngagementConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What must be so before the arm follows the hand."""

    mode: Annotated[
        EngagementMode,
        Meta(
            description="automatic: by itself, once per start of the remote site; on_request: by 'farhand engage'; "
            "hold_to_run or pedal: while the operator holds it down"
        ),
    ] = EngagementMode.AUTOMATIC
    frames: Annotated[int, Meta(ge=1, le=1000, description="good hand samples in a row before engaging")] = 30
    resume_frames: Annotated[int, Meta(ge=1, le=100, description="good samples in a row that end a hold")] = 3


class LeaseConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The right to operate this cell."""

    seconds: Annotated[
        float, Meta(ge=1, le=60, description="how long it lasts; the local site renews it five times as often, s")
    ] = 5.0
