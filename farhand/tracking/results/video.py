"""A track as a video of all views side by side: MPEG-4, which OpenCV writes wherever it has FFmpeg."""

import errno
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2

from common.cameras.camera import Image
from common.errors import CameraError, ConfigError
from farhand.tracking.results.tracked_pair import Take, TrackedPair

SUFFIX, CODEC = ".mp4", "mp4v"
ROOM_BYTES = 8_000_000  # for the index at the end, without which nothing of the file can be read
TRIAL_SIZE_PX = (64, 48)


def check_video(option: str, out: Path, fps: float | None) -> None:
    """ConfigError, before any work, if no video of this rate (Hz) can be written there; an earlier one stays."""
    if fps is None:
        raise ConfigError(f"{option}: live cameras do not state their frame rate; give it with --fps")
    part = _part(out)
    writer = _writer(part, fps, TRIAL_SIZE_PX)
    opened = writer.isOpened()
    writer.release()
    part.unlink(missing_ok=True)
    if not opened:
        raise ConfigError(
            f"{option} {out}: OpenCV cannot write MPEG-4 of {fps:g} frames per second here; install its own package "
            "(pip install opencv-python-headless), or leave the video out and take --annotate with a folder"
        )


@contextmanager
def overlay_video(out: Path, fps: float) -> Iterator[Take]:
    """A video of this rate (Hz) with a picture for each pair; an earlier one stays until this one can be played."""
    video = _Video(out.resolve(), fps)
    try:
        yield video.take
    finally:
        video.finish()


class _Video:
    """Opened with the first pair, whose picture states the size; takes its name once it can be read."""

    def __init__(self, out: Path, fps: float) -> None:
        self._out, self._part, self._fps = out, _part(out), fps
        self._writer: cv2.VideoWriter | None = None
        self._count = 0

    def take(self, pair: TrackedPair) -> None:
        """Write the picture of a pair; OSError before the disk is full."""
        picture = _even(pair.picture)
        if self._writer is None:
            self._writer = self._opened(picture)
        if shutil.disk_usage(self._part.parent).free < ROOM_BYTES:
            raise OSError(errno.ENOSPC, "no space is left on the disk", str(self._out))
        self._writer.write(picture)
        self._count += 1

    def _opened(self, picture: Image) -> cv2.VideoWriter:
        height, width = picture.shape[:2]
        writer = _writer(self._part, self._fps, (width, height))
        if not writer.isOpened():
            raise CameraError(
                f"cannot write {self._out}: OpenCV cannot make a video of {width}x{height} pixels; "
                "leave the video out and take --annotate with a folder"
            )
        return writer

    def finish(self) -> None:
        """Complete the file; CameraError if it does not hold what was drawn."""
        if self._writer is None:
            return
        self._writer.release()
        if self._count and _readable(self._part) == self._count:
            self._part.replace(self._out)
            return
        self._part.unlink(missing_ok=True)
        if self._count:
            raise CameraError(
                f"cannot write {self._out}: the video cannot be read back; free some space, or choose another folder"
            )


def _part(out: Path) -> Path:
    """The file while it is written; FFmpeg knows the format by the suffix."""
    return out.with_name(f"{out.stem}.part{out.suffix}")


def _writer(path: Path, fps: float, size_px: tuple[int, int]) -> cv2.VideoWriter:
    rate = round(fps, 2)  # MPEG-4 holds the rate as a fraction of small numbers
    return cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*CODEC), rate, size_px)


def _readable(path: Path) -> int:
    """Return how many pictures a video states in its index; 0 if it cannot be opened."""
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    try:
        return int(capture.get(cv2.CAP_PROP_FRAME_COUNT)) if capture.isOpened() else 0
    finally:
        capture.release()


def _even(picture: Image) -> Image:
    """The picture with an even number of rows and columns, as the codec needs; OpenCV would cut the last ones."""
    height, width = picture.shape[:2]
    padded: Image = cv2.copyMakeBorder(picture, 0, height % 2, 0, width % 2, cv2.BORDER_CONSTANT)  # type: ignore[assignment]  # cv2's stubs allow any dtype
    return padded
