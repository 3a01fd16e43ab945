"""Opens a camera by device, URL, video file or folder of images."""

import math
from pathlib import Path
from typing import Annotated

from msgspec import Meta

from common.cameras.camera import Camera
from common.cameras.images import ImageFolder
from common.cameras.opencv import DEFAULT_LATENCY_MS, LiveCamera, VideoFile
from common.errors import CameraError, ConfigError

DEFAULT_FOLDER_FPS = 30.0

Source = Annotated[int, Meta(ge=0)] | Annotated[str, Meta(min_length=1)]


def open_camera(source: Source, name: str, fps: float | None = None, latency_ms: float = DEFAULT_LATENCY_MS) -> Camera:
    """Open a device number or /dev path, a URL, a video file or a folder of images.

    `fps` overrides the rate of a recording and is requested from a live camera. Raises CameraError with the cure.
    """
    source = str(source)
    if fps is not None and not 0 < fps < math.inf:
        raise ConfigError(f"camera {name}: the frame rate must be positive, not {fps:g}")
    if source.isdecimal() or "://" in source or source.startswith("/dev/"):
        return LiveCamera(source, name, fps, latency_ms)
    path = Path(source)
    if path.is_dir():
        return ImageFolder(path, name, fps if fps is not None else DEFAULT_FOLDER_FPS)
    if path.exists():
        return VideoFile(path, name, fps)
    raise CameraError(
        f"camera {name}: {source} does not exist; give a device number, a URL, a video file or a folder of images"
    )


def recorded_fps(camera: Camera) -> float | None:
    """The frame rate of a recording, Hz; None for a live camera."""
    return camera.fps if isinstance(camera, VideoFile | ImageFolder) else None
