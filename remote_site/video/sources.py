"""The cameras of the cell from the configuration: real ones, each with a thread of its own, and simulated views."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

from common.cameras.camera import Camera, Frame
from common.cameras.live import LiveCamera
from common.cameras.lost_pictures import LostPictures
from common.cameras.sources import open_camera
from common.clock import NS_PER_S
from common.errors import CameraError, ConfigError
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.config import SIMULATED, CellConfig
from remote_site.simulation.memory import CellMemory
from remote_site.video.config import CameraConfig, VideoConfig

REOPEN_S = 2.0


class FrameSource(Protocol):
    """A camera of the cell: its newest frame without waiting, None before the first, or CameraError while it fails."""

    name: str
    noise_free: bool

    def newest(self) -> Frame | None: ...

    def close(self) -> None: ...


@dataclass(frozen=True, slots=True)
class SimulatedViews:
    """The views of simulated cameras: the cell that runs, and its memory."""

    cell: CellConfig
    robot: RobotConfig
    memory: CellMemory


class ThreadedCamera:
    """A real camera, or a recording in its place: a thread keeps its newest frame, and reopens it when it fails."""

    noise_free = False

    def __init__(self, name: str, open_it: Callable[[], Camera], lost: LostPictures | None = None) -> None:
        self.name = name
        self._open_it, self._lost = open_it, lost or LostPictures([name])
        self._frame: Frame | None = None
        self._failure = ""
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"camera-{name}", daemon=True)
        self._thread.start()

    def newest(self) -> Frame | None:
        """The newest frame, None before the first; CameraError while the camera fails."""
        if self._failure:
            raise CameraError(self._failure)
        return self._frame

    def close(self) -> None:
        """Stop reading; a read that hangs is left to its daemon thread."""
        self._ended.set()
        self._thread.join(timeout=0.2)

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                camera = self._open_it()
                self._failure = ""
                self._read(camera)
            except CameraError as error:
                self._failure = str(error)
            self._ended.wait(REOPEN_S)

    def _read(self, camera: Camera) -> None:
        start_ns = 0 if isinstance(camera, LiveCamera) else time.monotonic_ns()
        note_lost = self._lost.follow(self.name, camera)
        try:
            while not self._ended.is_set():
                frame = camera.read()
                note_lost()
                if frame is None:
                    raise CameraError(f"camera {self.name}: the recording has ended")
                capture_ns = start_ns + frame.capture_ns
                self._ended.wait(max(0.0, (capture_ns - time.monotonic_ns()) / NS_PER_S))
                self._frame = replace(frame, capture_ns=capture_ns)
        finally:
            note_lost()
            camera.close()


def open_sources(config: VideoConfig, views: SimulatedViews | None, lost: LostPictures | None) -> list[FrameSource]:
    """All cameras in the order of the configuration; what real ones lose is counted in `lost`.

    Raises ConfigError for a simulated camera without a cell, CameraError when views cannot be rendered here.
    """
    simulated = _open_simulated(config, views)
    return [simulated.get(camera.name) or _open_live(camera, config.fps, lost) for camera in config.cameras]


def _open_simulated(config: VideoConfig, views: SimulatedViews | None) -> dict[str, FrameSource]:
    names = [camera.name for camera in config.cameras if camera.source == SIMULATED]
    if not names:
        return {}
    if views is None:
        raise ConfigError("video: a camera is 'simulated', but no cell is simulated here; give it a device or URL")
    from remote_site.simulation.cell import build_cell  # noqa: PLC0415  # a real cell needs no MuJoCo
    from remote_site.video.cell_cameras import open_cell_cameras  # noqa: PLC0415

    cell, snapshot = build_cell(views.cell, views.robot, dressed=True), views.memory.snapshot
    return {camera.name: camera for camera in open_cell_cameras(names, cell, snapshot, config)}


def _open_live(camera: CameraConfig, fps: float, lost: LostPictures | None) -> FrameSource:
    open_it = partial(open_camera, camera.source, camera.name, fps, camera.latency_ms)
    return ThreadedCamera(camera.name, open_it, lost)
