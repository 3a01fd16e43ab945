"""The parameters of the video: cameras, their rate, when one is frozen or dark."""

from typing import Annotated

import msgspec
from msgspec import Meta

from common.cameras.camera import Source
from common.messages.base import Name
from common.text import name_mistake
from remote_site.simulation.config import SIMULATED
from remote_site.video.streaming.codec_choice import CodecPreference

PROJECTION_NUMBERS = 12
Pixels = Annotated[int, Meta(ge=16, le=7680)]


class CameraConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One view of the cell."""

    name: Name
    source: Annotated[
        Source, Meta(description="'simulated' (the cell's view of this name), device, URL, file or folder")
    ] = SIMULATED
    latency_ms: Annotated[
        float, Meta(ge=0, le=1000, description="exposure to arrival, where the camera's driver gives no time stamps")
    ] = 30.0
    projection: Annotated[
        tuple[float, ...] | None,
        Meta(description="of a calibrated camera: 3 x 4, row by row, from the base frame (m) to pixels"),
    ] = None
    size_px: Annotated[
        tuple[Pixels, Pixels] | None,
        Meta(description="width and height of the pictures that projection is for; else video.width, video.height"),
    ] = None
    on_tool: Annotated[bool, Meta(description="the camera rides on the tool: projection is from the tool's frame")] = (
        False
    )

    def __post_init__(self) -> None:
        if wrong := name_mistake(self.name):
            raise ValueError(f"name: it {wrong}")
        if "/" in self.name:
            raise ValueError(f"name: '{self.name}' has a slash, which divides the topics of a recording; leave it out")
        if self.size_px is not None and self.projection is None:
            raise ValueError("size_px: it is the size of the pictures that projection is for; give projection, too")
        if self.projection is not None and len(self.projection) != PROJECTION_NUMBERS:
            raise ValueError(f"projection: 12 numbers, three rows of four, not {len(self.projection)}")


class VideoConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Four views by default, as in thesis section 4.1.3: two in front, one at the side, one on the end-effector.

    None (`cameras = []`) where the operator sees the arm itself.
    """

    cameras: Annotated[tuple[CameraConfig, ...], Meta(max_length=16)] = (
        CameraConfig(name="front_high"),
        CameraConfig(name="front_low"),
        CameraConfig(name="side"),
        CameraConfig(name="gripper"),
    )
    width: Annotated[int, Meta(ge=16, le=1920, description="of simulated views, pixels")] = 640
    height: Annotated[int, Meta(ge=16, le=1080, description="of simulated views, pixels")] = 480
    calibrated: Annotated[
        bool, Meta(description="publish the projection of simulated views, so that the page can draw over them")
    ] = False
    fps: Annotated[
        float, Meta(gt=0, le=120, description="frames per second of each camera; under half of it is slow")
    ] = 30.0
    codec: Annotated[
        CodecPreference,
        Meta(description="jpeg, h264 (needs PyAV), or auto: JPEG while the operator's link carries it, then H.264"),
    ] = CodecPreference.AUTO
    quality: Annotated[int, Meta(ge=10, le=100, description="JPEG quality, while the operator's link carries it")] = 80
    dark_level: Annotated[
        float, Meta(ge=0, le=255, description="a picture is dark if its brightness is nearly all below this, 0 to 255")
    ] = 32.0
    frozen_ms: Annotated[float, Meta(ge=50, le=5000, description="without a new picture a camera is frozen")] = 500.0
    status_hz: Annotated[
        float, Meta(gt=0, le=30, description="rate of the status of a frozen or missing camera, Hz")
    ] = 5.0
    nice: Annotated[int, Meta(ge=0, le=19, description="niceness of the video process")] = 5
