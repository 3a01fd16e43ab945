"""Parameters of the marker tracker."""

from typing import Annotated

import msgspec
from msgspec import Meta


class MarkersConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How bright the markers are, how the tracker learns their distances, and what an open hand is."""

    min_contrast: Annotated[
        int, Meta(ge=5, le=250, description="least brightness of a marker above its surroundings, grey levels")
    ] = 40
    initial_pairs: Annotated[
        int, Meta(ge=1, le=1000, description="instants from which the distances of the markers are learned")
    ] = 10
    open_ratio: Annotated[
        float,
        Meta(
            gt=1,
            le=3,
            description="the hand is open when the distance index to thumb over that of wrist to thumb is so many "
            "times what was learned",
        ),
    ] = 1.12
