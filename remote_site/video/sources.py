"""From the configuration to the cameras of the cell: real ones, each with a thread of its own, and simulated views."""

from dataclasses import dataclass
from functools import partial
from typing import Protocol

from common.cameras.camera import Frame
from common.cameras.sources import open_camera
from common.errors import ConfigError
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.config import SIMULATED, CellConfig
from remote_site.simulation.memory import CellMemory
from remote_site.video.config import CameraConfig, VideoConfig
from remote_site.video.live_camera import ThreadedCamera


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


def open_sources(config: VideoConfig, views: SimulatedViews | None) -> list[Source]:
    """All cameras in the order of the configuration.

    Raises ConfigError for a simulated camera without a cell, CameraError when views cannot be rendered here.
    """
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
    return {camera.name: camera for camera in open_cell_cameras(names, cell, snapshot, config)}


def _open_live(camera: CameraConfig, fps: float) -> Source:
    return ThreadedCamera(camera.name, partial(open_camera, camera.source, camera.name, fps, camera.latency_ms))
