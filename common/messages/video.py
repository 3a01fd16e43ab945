"""Pictures of the cell, requests for key frames, and what a console has received and shown; frozen structs."""

from enum import StrEnum
from typing import Annotated

import msgspec

from common.messages.base import Count, Difference, Message, Name, Text

# Far beyond what can be, and small enough that sums of them are finite.
AgeMs = Annotated[float, msgspec.Meta(ge=0, le=1e12)]
RateHz = Annotated[float, msgspec.Meta(ge=0, le=1e6)]


class CameraStatus(StrEnum):
    """The state of a camera: whether it shows the cell as it is now."""

    LIVE = "live"
    DARK = "dark"
    SLOW = "slow"
    FROZEN = "frozen"
    MISSING = "missing"


class Codec(StrEnum):
    """The compression of pictures: each for itself, or as H.264 (Annex B, parameter sets in every key frame)."""

    JPEG = "jpeg"
    H264 = "h264"


class VideoFrame(Message, frozen=True):
    """One camera picture, or the report that there is none: `data` is empty where `status` is frozen or missing.

    Pictures of a dark or slow camera are sent too; `reason` states its problem. A `key` picture needs no other to be
    decoded, as every JPEG; any other needs all since the last key picture. `ahead_ns` is by how much steady time was
    ahead of the sender's clock at the exposure (`common/steady_time.py`), None from a sender that does not tell.
    """

    camera: Name
    seq: Count
    capture_ns: Count
    capture_estimated: bool
    status: CameraStatus
    reason: Text
    width: Annotated[int, msgspec.Meta(ge=0, le=8192)]
    height: Annotated[int, msgspec.Meta(ge=0, le=8192)]
    codec: Codec
    key: bool
    data: bytes
    ahead_ns: Difference | None = None


class ViewCame(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The newest picture of one camera received by the console's host, its age then, and the rate of arrival."""

    seq: Count
    age_ms: AgeMs
    fps: RateHz


class ViewShown(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The newest picture of one camera painted by a console, its age then, and the rate of painting.

    `came` distinguishes the link's part of the delay from the page's.
    """

    seq: Count
    capture_ns: Count
    age_ms: AgeMs
    fps: RateHz
    came: ViewCame


class ViewsShown(Message, frozen=True):
    """The pictures that a console shows, at 10 Hz, so that the remote site sends only as much as arrives in time.

    `session` is a random number chosen at each start of the console, `lease` the number of its operator's lease, 0
    without one; `h264` is whether the page that operates decodes H.264. `waited_ms` is for how long the console has
    lately waited for its processor, at most: what comes that late is not the link's fault.
    """

    session: Count
    sent_ns: Count
    lease: Count
    h264: bool
    views: Annotated[dict[Name, ViewShown], msgspec.Meta(max_length=16)]
    waited_ms: AgeMs = 0.0


class KeyFrameRequest(Message, frozen=True):
    """A viewer cannot decode a camera's pictures after `after_seq`, its newest, without a key frame.

    It is repeated until one comes, and has no effect where a later key frame has been sent already.
    """

    camera: Name
    after_seq: Count
