"""The parameters of the operator's own views as the console shows them."""

from typing import Annotated

import msgspec
from msgspec import Meta


class PreviewConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Pictures of the operator with what was found in them; made only while a console looks at them."""

    fps: Annotated[float, Meta(gt=0, le=60, description="pictures per second of each view, at most")] = 12.0
    width: Annotated[int, Meta(ge=160, le=3840, description="pixels; a narrower view stays as it is")] = 640
    quality: Annotated[int, Meta(ge=10, le=100, description="JPEG quality")] = 70
