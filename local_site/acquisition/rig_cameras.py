"""Opens the cameras that a rig was calibrated with: a source for each, in the rig's order, or one of them alone."""

from collections.abc import Sequence
from contextlib import ExitStack

import msgspec

from common.cameras.camera import Camera
from common.cameras.opencv import DEFAULT_LATENCY_MS
from common.cameras.sources import Source, open_camera
from common.errors import CameraError, ConfigError
from local_site.calibration.rig import Rig
from local_site.tracking.choice import TrackingConfig


def of_one_camera(rig: Rig, tracking: TrackingConfig) -> tuple[Rig, TrackingConfig]:
    """The rig of the monocular tracker's camera alone, and that tracker's configuration for it; ConfigError without."""
    number, replaced = tracking.monocular.camera, msgspec.structs.replace
    if number >= len(rig.cameras):
        raise ConfigError(f"tracking.monocular.camera is {number}, but the rig has {len(rig.cameras)} cameras, from 0")
    monocular = replaced(tracking.monocular, camera=0)
    alone = replaced(tracking, method="monocular", monocular=monocular)
    return replaced(rig, cameras=(rig.cameras[number],)), alone


def open_rig_cameras(
    rig: Rig, sources: Sequence[Source], fps: float | None, latency_ms: float = DEFAULT_LATENCY_MS
) -> list[Camera]:
    """A camera for each of the rig's, by its name there; CameraError if one cannot be opened or the numbers differ."""
    if len(sources) != len(rig.cameras):
        names = ", ".join(camera.name for camera in rig.cameras)
        raise CameraError(
            f"the rig has {len(rig.cameras)} cameras ({names}), but {len(sources)} are given: "
            "give one for each, in this order, or calibrate again with those you have"
        )
    with ExitStack() as opened:
        cameras = []
        for calibrated, source in zip(rig.cameras, sources, strict=True):
            cameras.append(open_camera(source, calibrated.name, fps, latency_ms))
            opened.callback(cameras[-1].close)
        opened.pop_all()
    return cameras
