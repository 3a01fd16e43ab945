"""Pictures of the cell, and what of them a console has received and shown; frozen structs."""

from enum import StrEnum
from typing import Annotated

import msgspec

from common.messages.base import (
    Count,
    Message,
    Name,
    Text,
)


class CameraStatus(StrEnum):
    """Whether a camera's picture shows the cell as it is now."""

    LIVE = "live"
    DARK = "dark"
    SLOW = "slow"
    FROZEN = "frozen"
    MISSING = "missing"


class VideoFrame(Message, frozen=True):
    """One camera picture, or the word that there is none: `jpeg` is empty where `status` is frozen or missing.

    A dark or slow camera's pictures are sent too; `reason` says what is the matter with it.
    """

    camera: Name
    seq: Count
    capture_ns: Count
    capture_estimated: bool
    status: CameraStatus
    reason: Text
    width: Annotated[int, msgspec.Meta(ge=0, le=8192)]
    height: Annotated[int, msgspec.Meta(ge=0, le=8192)]
    jpeg: bytes


class ViewCame(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The newest picture of one camera that has come to the console's host, how old it was then, how many come."""

    seq: Count
    age_ms: Annotated[float, msgspec.Meta(ge=0)]
    fps: Annotated[float, msgspec.Meta(ge=0)]


class ViewShown(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The newest picture of one camera that a console has painted, how old it was then, and how many it paints.

    `came` tells the link's share of that from the page's.
    """

    seq: Count
    capture_ns: Count
    age_ms: Annotated[float, msgspec.Meta(ge=0)]
    fps: Annotated[float, msgspec.Meta(ge=0)]
    came: ViewCame


class ViewsShown(Message, frozen=True):
    """What the operator's console shows, at 10 Hz, so that the remote site sends as much as arrives in time.

    `session` is a random number chosen at each start of the console, `lease` the number of its operator's lease, 0
    without one.
    """

    session: Count
    sent_ns: Count
    lease: Count
    views: Annotated[dict[Name, ViewShown], msgspec.Meta(max_length=16)]
