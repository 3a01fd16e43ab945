"""Parameters of the silhouette tracker."""

from typing import Annotated

import msgspec
from msgspec import Meta


class SilhouetteConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the silhouette tracker starts, and what it takes for granted about a body."""

    initial_pairs: Annotated[
        int, Meta(ge=1, le=1000, description="pairs of images from which body lengths are learned, thesis 3.1")
    ] = 10
    right_arm: Annotated[
        bool, Meta(description="which arm is tracked; it tells on which side of the hand the index is")
    ] = True
