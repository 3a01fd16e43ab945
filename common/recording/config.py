"""The parameters of recording: where, what begins it, how files are split, how much is kept."""

from enum import StrEnum
from typing import Annotated

import msgspec
from msgspec import Meta


class StartPolicy(StrEnum):
    """The cause that begins a recording: the recorder's own start, or the lease's holder."""

    AT_ONCE = "at_once"
    ON_REQUEST = "on_request"


class EpisodeBounds(StrEnum):
    """The cause that begins and ends an episode: each engagement by itself, or requests alone."""

    ENGAGEMENT = "engagement"
    REQUESTS = "requests"


class RecordConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of a site's recorder; nothing is recorded unless one is started."""

    start: Annotated[
        StartPolicy, Meta(description="at_once: while the recorder runs; on_request: the lease's holder begins it")
    ] = StartPolicy.AT_ONCE
    episodes: Annotated[
        EpisodeBounds, Meta(description="engagement: each is an episode; requests: only what key or command bounds")
    ] = EpisodeBounds.ENGAGEMENT
    folder: Annotated[
        str, Meta(description="where recordings are kept; empty: in the service's or the user's state folder")
    ] = ""
    task: Annotated[str, Meta(max_length=400, description="sentence for episodes until another is given")] = ""
    split_minutes: Annotated[float, Meta(ge=0.1, le=1440, description="a new file after this time")] = 30.0
    split_gb: Annotated[float, Meta(ge=0.001, le=1000, description="a new file after this size, 10^9 bytes")] = 4.0
    keep_gb: Annotated[
        float, Meta(ge=0.001, le=1e6, description="the oldest recordings in the folder are removed beyond this")
    ] = 100.0


class OperatorRecordConfig(RecordConfig, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of a local site's recorder."""

    operator_pictures: Annotated[
        bool, Meta(description="the operator's views too, as the page shows them; the page's mark says so")
    ] = False
