"""Opens the cameras of a calibration, set as a local site's configuration sets them."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field

from common.cameras.camera import Camera
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.cameras.sources import open_camera
from local_site.config import LocalConfig


@dataclass(frozen=True, slots=True)
class CameraSetup:
    """The rate asked of all cameras, which may give another, and the settings of each by its name."""

    fps: float | None = None
    settings: Mapping[str, CameraSettings] = field(default_factory=dict)


def configured_cameras(site: LocalConfig | None, names: Sequence[str]) -> CameraSetup:
    """The cameras' setup of a local site, nothing without one; ConfigError for settings of an unknown name."""
    if site is None:
        return CameraSetup()
    operator = site.operator
    return CameraSetup(operator.fps, operator.settings_of(names))


def open_named(sources: Mapping[str, str], setup: CameraSetup) -> list[Camera]:
    """A camera for each name; CameraError, with the others closed, if one cannot be opened or does otherwise."""
    with ExitStack() as opened:
        cameras = [
            opened.enter_context(
                closing(open_camera(source, name, setup.fps, settings=setup.settings.get(name, AS_IT_IS)))
            )
            for name, source in sources.items()
        ]
        opened.pop_all()
    return cameras
