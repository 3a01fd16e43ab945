"""The messages of pages to the console: JSON, validated."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta
from msgspec.structs import replace

from common.errors import MessageError
from common.messages.base import Count, Name
from common.messages.hand import ClutchKey, OperatorSettings
from common.messages.recording import EpisodeOutcome
from common.messages.requests import EngagementAction, OperatorAction, PicturePoint, RecordAction
from common.messages.robot import Asker

Digits = Annotated[str, Meta(pattern=r"^[0-9]{1,19}$")]  # a number that JavaScript would round
Milliseconds = Annotated[float, Meta(ge=0, le=1e15)]


class PageMessage(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="type"):
    """Base of a page's messages; `type` selects one."""


class Beat(PageMessage, frozen=True, tag="beat"):
    """The page's heartbeat: its own time in ms, to be echoed, and whether the hold-to-run key is down.

    `heard_ms` is the console's time in the newest echo that the page has heard, None before the first: the beat is
    not older. `assist` is the target that was offered when the key of fine adjustment went down, None while it is up.
    `clutch` is `unseen` once the page could not see any more whether its key or button was let go.
    """

    page_ms: Milliseconds
    heard_ms: Milliseconds | None
    down: bool
    assist: Name | None = None
    clutch: ClutchKey = ClutchKey.UP


class FrameTaken(PageMessage, frozen=True, tag="taken"):
    """The page has painted, or skipped, a frame of this view."""

    view: Name


class FrameLost(PageMessage, frozen=True, tag="lost"):
    """The page could not decode a frame of this view."""

    view: Name


class Painted(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The newest frame of a view that the page has painted, its age then, and how many it paints a second."""

    seq: Count
    age_ms: Milliseconds
    fps: Annotated[float, Meta(ge=0, le=1000)]


class Shown(PageMessage, frozen=True, tag="shown"):
    """A report of what the page shows, at 10 Hz, and of whether it decodes H.264."""

    h264: bool
    views: Annotated[dict[Name, Painted], Meta(max_length=24)]


class Ask(PageMessage, frozen=True, tag="ask"):
    """A request for the remote site's session; `id` comes back with the answer.

    `seen` is the newest halt that the page has shown for long enough to be read (`RobotState.halted_ns`).
    """

    id: Count
    action: EngagementAction
    seen: Digits = "0"


class ShownAsker(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The one who asks for the lease, as the page showed it."""

    name: Name
    session: Digits

    @property
    def asker(self) -> Asker:
        """The same as the sites name it."""
        return Asker(self.name, int(self.session))


class AskLease(PageMessage, frozen=True, tag="ask_lease"):
    """A request about the lease, for the local site; `id` comes back with the answer.

    `to` is who asked for the lease when the operator consented to hand it over.
    """

    id: Count
    action: OperatorAction
    to: ShownAsker | None = None


class AskRecord(PageMessage, frozen=True, tag="ask_record"):
    """A request for the remote site's recorder; `id` comes back with the answer."""

    id: Count
    action: RecordAction
    outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN


class MarkJoints(PageMessage, frozen=True, tag="mark_joints"):
    """The joints in the operator's picture, for a tracker of one camera; `id` comes back with the answer."""

    id: Count
    shoulder: PicturePoint
    elbow: PicturePoint
    wrist: PicturePoint


class TakeSeat(PageMessage, frozen=True, tag="take_seat"):
    """This page wants to operate."""

    id: Count


class LeaveSeat(PageMessage, frozen=True, tag="leave_seat"):
    """This page wants only to watch."""

    id: Count


class NewOrigins(PageMessage, frozen=True, tag="new_origins"):
    """The operator takes new origins in an instant, without a hold."""


class Play(PageMessage, frozen=True, tag="play"):
    """The wanted course of a replay: what is not named stays. `position_s` counts from the recording's beginning."""

    playing: bool | None = None
    speed: Annotated[float, Meta(ge=0.1, le=16)] | None = None
    position_s: Annotated[float, Meta(ge=0, le=1e7)] | None = None


class Steer(PageMessage, frozen=True, tag="steer"):
    """The operator's changes of scales and locks, within the bounds of the settings; what is not named stays."""

    scale: Annotated[float, Meta(ge=0.01, le=5)] | None = None
    rotation_scale: Annotated[float, Meta(ge=0, le=2)] | None = None
    locks: dict[Literal["x", "y", "z", "roll", "pitch", "yaw"], bool] = {}

    def apply(self, settings: OperatorSettings) -> OperatorSettings:
        """The settings with these changes, of a higher revision if any changes."""
        scales = {"scale": self.scale, "rotation_scale": self.rotation_scale}
        changed = {name: value for name, value in scales.items() if value is not None}
        wanted = replace(settings, locks=replace(settings.locks, **self.locks), **changed)
        return settings if wanted == settings else replace(wanted, revision=settings.revision + 1)


AnyPageMessage = (
    Beat
    | FrameTaken
    | FrameLost
    | Shown
    | Ask
    | AskLease
    | AskRecord
    | MarkJoints
    | Play
    | TakeSeat
    | LeaveSeat
    | NewOrigins
    | Steer
)
DECODER: msgspec.json.Decoder[AnyPageMessage] = msgspec.json.Decoder(AnyPageMessage)


def parse(text: str) -> AnyPageMessage:
    """The page's message; MessageError when it is none that is known."""
    try:
        return DECODER.decode(text)
    except msgspec.DecodeError as error:
        raise MessageError("invalid", f"from a page: {error}") from error
