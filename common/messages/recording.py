"""The state of a recorder, as the site it records publishes it; frozen structs."""

from enum import StrEnum
from typing import Annotated

import msgspec

from common.messages.base import Count, Message, Text

Seconds = Annotated[float, msgspec.Meta(ge=0)]


class EpisodeOutcome(StrEnum):
    """How the task of an episode went."""

    UNKNOWN = "unknown"
    SUCCESS = "success"
    FAILURE = "failure"


class RecordingState(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The state of a recorder: whether it is `writing`, and the pictures of the operator with it (`operator_pictures`).

    With `on_request` the lease's holder may begin and end the recording. `episode` is the number of the one that is
    under way (`episode_open`) or was the last, 0 before the first; `task` and `outcome` are its own. `lost` counts what
    the recorder was too slow to take. `alarm` states why a recording has ended that nobody ended, else it is empty.
    `seconds` is how long the recording has lasted, `size_bytes` what it has written, `episode_seconds` how long the
    episode has lasted, or did.
    """

    writing: bool
    on_request: bool
    operator_pictures: bool
    episode: Count
    episode_open: bool
    task: Text
    outcome: EpisodeOutcome
    lost: Count
    alarm: Text
    seconds: Seconds = 0.0
    size_bytes: Count = 0
    episode_seconds: Seconds = 0.0


class RecordingNotice(Message, frozen=True):
    """The state of the local site's recorder, for the console of the same host."""

    state: RecordingState
