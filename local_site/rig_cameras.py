"""Opens the cameras that a rig was calibrated with: a source for each, in the rig's order."""

from collections.abc import Sequence
from contextlib import ExitStack

from common.cameras.camera import Camera
from common.cameras.opencv import DEFAULT_LATENCY_MS
from common.cameras.sources import Source, open_camera
from common.errors import CameraError
from local_site.calibration.rig import Rig


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
