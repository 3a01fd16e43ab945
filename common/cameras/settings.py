"""Settings of a camera: size, rate, pixel format, exposure, gain, focus, and the latency of its time stamps."""

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from common.clock import NS_PER_MS

DEFAULT_LATENCY_MS = 30.0

Auto = Literal["auto"]
Pixels = Annotated[int, Meta(ge=16, le=16384)]
Milliseconds = Annotated[float, Meta(ge=0, le=1000)]


class CameraSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings asked of a live camera, and verified; a value that is not given leaves the camera as it is.

    Of a recording only `fps` counts. `gain` and `focus` are in the driver's own units. Raises ValueError for a width
    without a height.
    """

    width_px: Annotated[Pixels | None, Meta(description="width of the pictures; give the height too")] = None
    height_px: Annotated[Pixels | None, Meta(description="height of the pictures; give the width too")] = None
    fps: Annotated[
        Annotated[float, Meta(gt=0, le=1000)] | None, Meta(description="frames per second that the camera must give")
    ] = None
    pixel_format: Annotated[
        Annotated[str, Meta(pattern="^[ -~]{4}$")] | None,
        Meta(description='four-character code of what the camera sends: "MJPG", "YUYV"'),
    ] = None
    exposure_ms: Annotated[
        Annotated[float, Meta(gt=0, le=1000)] | Auto | None,
        Meta(description='how long a picture is exposed, or "auto"; a fixed time keeps the rate in a dim room'),
    ] = None
    gain: Annotated[int | None, Meta(description="in the driver's units: v4l2-ctl --list-ctrls")] = None
    focus: Annotated[
        int | Auto | None,
        Meta(description='in the driver\'s units, or "auto"; a calibrated camera needs a fixed one'),
    ] = None
    latency_ms: Annotated[
        Milliseconds | None, Meta(description="exposure to arrival, where the driver gives no time stamps")
    ] = None
    stamp_latency_ms: Annotated[
        Annotated[float, Meta(ge=-100, le=1000)] | None,
        Meta(description="exposure to the driver's time stamp, where it gives them; negative where it comes first"),
    ] = None

    def __post_init__(self) -> None:
        if (self.width_px is None) != (self.height_px is None):
            raise ValueError("width_px and height_px belong together: give both or neither")

    @property
    def size_px(self) -> tuple[int, int] | None:
        """Width and height; None where they are not given."""
        return None if self.width_px is None or self.height_px is None else (self.width_px, self.height_px)

    @property
    def latency_ns(self) -> int:
        """From the exposure to the arrival of a frame."""
        return round((DEFAULT_LATENCY_MS if self.latency_ms is None else self.latency_ms) * NS_PER_MS)

    @property
    def stamp_latency_ns(self) -> int:
        """From the exposure to the driver's time stamp of a frame."""
        return round((self.stamp_latency_ms or 0.0) * NS_PER_MS)

    def overridden_by(self, other: "CameraSettings") -> "CameraSettings":
        """These settings, but the other's where it gives a value."""
        return msgspec.structs.replace(self, **given(other))


AS_IT_IS = CameraSettings()


def given(settings: CameraSettings) -> dict[str, Any]:
    """The values that are given, by their keys."""
    return {key: value for key, value in msgspec.structs.asdict(settings).items() if value is not None}
