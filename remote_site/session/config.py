"""The parameters of engagement and lease."""

from enum import StrEnum
from typing import Annotated

import msgspec
from msgspec import Meta

ACCEPTANCE = "the arm may move as soon as a hand is seen"


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
            description="on_request: by 'farhand engage' or on the page; hold_to_run or pedal: while the operator "
            "holds it down; automatic: by itself, once, within a minute of the start, for robots that are not real"
        ),
    ] = EngagementMode.ON_REQUEST
    automatic_accepted: Annotated[
        str, Meta(description=f"automatic engagement of a real robot needs this sentence: {ACCEPTANCE!r}")
    ] = ""
    frames: Annotated[int, Meta(ge=1, le=1000, description="good hand samples in a row before engaging")] = 30
    resume_frames: Annotated[int, Meta(ge=1, le=100, description="good samples in a row that end a hold")] = 3


class LeaseConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The right to operate this cell."""

    seconds: Annotated[
        float, Meta(ge=1, le=60, description="how long it lasts; the local site renews it five times as often, s")
    ] = 5.0
