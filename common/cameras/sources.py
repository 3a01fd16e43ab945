"""Opens a camera by device, URL, video file or folder of images; OpenCV reads all but the folder."""

import math
from pathlib import Path

import cv2

from common.cameras.camera import Camera, Frame, Image, Source
from common.cameras.images import ImageFolder
from common.cameras.live import LiveCamera
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.cameras.shown_source import shown_source
from common.clock import NS_PER_S
from common.errors import CameraError, ConfigError

DEFAULT_FOLDER_FPS = 30.0
MAX_STATED_FRAMES = 1e8  # more is what OpenCV makes of an index without a duration
COUNTING_SUFFIXES = frozenset({".avi", ".mp4", ".m4v", ".mov"})  # of others OpenCV guesses the count by the duration
USUALLY_MISSING = 0.01  # of the frames that a file states: an index may count one that was never written


def _as_image(array: object) -> Image:
    return array  # type: ignore[return-value]  # cv2's stubs allow any dtype; an 8-bit source gives uint8


class VideoFile:
    """A recording; frame k is stamped k / fps from the start, however fast it is read.

    Where it ends too early, `damage` says so afterwards; until then, and else, it is empty.
    """

    def __init__(self, path: Path, name: str, fps: float | None = None) -> None:
        self.name, self.damage = name, ""
        self._path = path
        unreadable = f"camera {name}: {path} is not a video file that can be read"
        if not path.is_file():  # OpenCV would print it, though it may be a URL that was typed wrongly
            raise CameraError(unreadable)
        self._capture = cv2.VideoCapture(str(path))
        if not self._capture.isOpened():
            raise CameraError(unreadable)
        self.fps = fps if fps is not None else float(self._capture.get(cv2.CAP_PROP_FPS))
        if not (math.isfinite(self.fps) and self.fps > 0):
            raise CameraError(f"camera {name}: {path} does not state its frame rate; give it with --fps")
        count = float(self._capture.get(cv2.CAP_PROP_FRAME_COUNT))
        self.stated_frames = int(count) if 0 < count < MAX_STATED_FRAMES else None
        self._seq = 0

    def read(self) -> Frame | None:
        """The next frame of the file, None at its end."""
        ok, image = self._capture.read()
        if not ok:
            self.damage = self._describe_damage()
            return None
        frame = Frame(_as_image(image), round(self._seq * NS_PER_S / self.fps), self._seq)
        self._seq += 1
        return frame

    def _describe_damage(self) -> str:
        """Describe what the file states and does not hold, as a sentence with the cure; empty if it is whole."""
        stated = self.stated_frames or 0
        if self._path.suffix.lower() not in COUNTING_SUFFIXES or stated - self._seq <= max(1, USUALLY_MISSING * stated):
            return ""
        return (
            f"camera {self.name}: {self._path} is damaged or was cut off: decoding ended at picture {self._seq}, but "
            f"it states {stated}; copy it again or record anew"
        )

    def close(self) -> None:
        self._capture.release()


def open_camera(
    source: Source,
    name: str,
    fps: float | None = None,
    latency_ms: float | None = None,
    settings: CameraSettings = AS_IT_IS,
) -> Camera:
    """Open a device number or /dev path, a URL, a video file or a folder of images.

    `fps` overrides the rate of a recording and is asked of a live camera, which may give another. `settings` are
    asked of a live camera too, and verified; where they have a rate or a latency, it counts instead of `fps` or
    `latency_ms`. Raises CameraError with the cure.
    """
    source = str(source)
    fps = fps if settings.fps is None else settings.fps
    if fps is not None and not 0 < fps < math.inf:
        raise ConfigError(f"camera {name}: the frame rate must be positive, not {fps:g}")
    if source.isdecimal() or "://" in source or source.startswith("/dev/"):
        return LiveCamera(source, name, CameraSettings(latency_ms=latency_ms).overridden_by(settings), fps)
    path = Path(source)
    if path.is_dir():
        return ImageFolder(path, name, fps if fps is not None else DEFAULT_FOLDER_FPS)
    if path.exists():
        return VideoFile(path, name, fps)
    raise CameraError(
        f"camera {name}: {shown_source(source)} does not exist; give a device number, a URL, a video file or a folder "
        "of images"
    )


def recorded_fps(camera: Camera) -> float | None:
    """The frame rate of a recording, Hz; None for a live camera."""
    return camera.fps if isinstance(camera, VideoFile | ImageFolder) else None


def stated_frames(camera: Camera) -> int | None:
    """Return how many frames a recording states; None for a live camera, and where a file states nothing.

    Of a folder the number is exact. A file's index may be damaged or guessed, so it is a hint.
    """
    return camera.stated_frames if isinstance(camera, VideoFile | ImageFolder) else None


def damage_of(camera: Camera) -> str:
    """Describe what is wrong with a recording that has come to its end, as a sentence with the cure; else empty."""
    return camera.damage if isinstance(camera, VideoFile) else ""
