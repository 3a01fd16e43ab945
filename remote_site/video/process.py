"""The video process: every camera at its rate, staggered, each picture or its absence published."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import cv2

from common.cameras.camera import Frame
from common.cameras.sources import open_camera
from common.clock import NS_PER_MS, NS_PER_S
from common.errors import CameraError, ConfigError
from common.messages import VideoFrame
from common.service import be_nice
from remote_site.config import RobotConfig
from remote_site.shared_memory import CellMemory
from remote_site.simulation.config import CellConfig
from remote_site.video.config import SIMULATED, CameraConfig, VideoConfig
from remote_site.video.live_camera import ThreadedCamera
from remote_site.video.stream import CameraStream

LIVE_POLL_NS = 5 * NS_PER_MS


class Source(Protocol):
    """Where pictures come from: the newest frame at once, or CameraError when there is none to be had."""

    name: str
    noise_free: bool

    def newest(self) -> Frame | None: ...

    def close(self) -> None: ...


@dataclass(frozen=True, slots=True)
class SimulatedViews:
    """What simulated cameras show: the cell that runs, and its memory."""

    cell: CellConfig
    robot: RobotConfig
    memory: CellMemory


@dataclass(slots=True)
class _Slot:
    source: Source
    stream: CameraStream
    period_ns: int
    due_ns: int

    def serve(self, now_ns: int) -> VideoFrame | None:
        """The message due now, if any; deadlines already gone are skipped, not caught up."""
        self.due_ns += self.period_ns * max(1, (now_ns - self.due_ns) // self.period_ns + 1)
        try:
            return self.stream.take(self.source.newest(), now_ns)
        except CameraError as error:
            return self.stream.missing(str(error), now_ns)


def run_video(
    config: VideoConfig,
    views: SimulatedViews | None,
    publish: Callable[[VideoFrame], None],
    should_stop: Callable[[], bool],
    beat: Callable[[], None],
) -> None:
    """Stream every camera until `should_stop`; `views` is None where no cell is simulated.

    Raises ConfigError for a simulated camera without a cell, CameraError when views cannot be rendered here.
    """
    be_nice(config.nice)
    cv2.setNumThreads(1)
    slots = _open_slots(config, _open_sources(config, views))
    try:
        while not should_stop():
            _serve_next(slots, publish)
            beat()
    finally:
        for slot in slots:
            slot.source.close()


def _serve_next(slots: Sequence[_Slot], publish: Callable[[VideoFrame], None]) -> None:
    slot = min(slots, key=lambda s: s.due_ns)
    delay_ns = slot.due_ns - time.monotonic_ns()
    if delay_ns > 0:
        time.sleep(delay_ns / NS_PER_S)
    message = slot.serve(time.monotonic_ns())
    if message is not None:
        publish(message)


def _open_sources(config: VideoConfig, views: SimulatedViews | None) -> list[Source]:
    simulated = _open_simulated(config, views)
    return [simulated.get(camera.name) or _open_live(camera, config.fps) for camera in config.cameras]


def _open_simulated(config: VideoConfig, views: SimulatedViews | None) -> dict[str, Source]:
    names = [camera.name for camera in config.cameras if camera.source == SIMULATED]
    if not names:
        return {}
    if views is None:
        raise ConfigError("video: a camera is 'simulated', but no cell is simulated here; give it a device or URL")
    from remote_site.simulation.cell import build_cell  # noqa: PLC0415  # a real cell needs no MuJoCo
    from remote_site.video.cell_cameras import open_cell_cameras  # noqa: PLC0415

    cell, snapshot = build_cell(views.cell, views.robot), views.memory.snapshot
    return {camera.name: camera for camera in open_cell_cameras(names, cell, snapshot, config.width, config.height)}


def _open_live(camera: CameraConfig, fps: float) -> Source:
    return ThreadedCamera(camera.name, partial(open_camera, camera.source, camera.name, fps, camera.latency_ms))


def _open_slots(config: VideoConfig, sources: Sequence[Source]) -> list[_Slot]:
    now_ns, frame_ns = time.monotonic_ns(), round(NS_PER_S / config.fps)
    slots = []
    for k, source in enumerate(sources):
        period_ns = frame_ns if source.noise_free else LIVE_POLL_NS
        stream = CameraStream(source.name, config, noise_free=source.noise_free)
        slots.append(_Slot(source, stream, period_ns, now_ns + k * frame_ns // len(sources)))
    return slots
