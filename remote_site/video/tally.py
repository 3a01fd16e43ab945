"""What the video process has sent, camera by camera, in memory that it shares with the process that forked it."""

import mmap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.messages.video import CameraStatus, VideoFrame

STATUSES = tuple(CameraStatus)
BYTES, CAPTURE_NS = len(STATUSES), len(STATUSES) + 1
FIELDS = len(STATUSES) + 2
COUNT_BYTES = 8


@dataclass(frozen=True, slots=True)
class CameraTally:
    """One camera: messages by status, bytes of pictures, exposure of the newest live picture (ns, 0 without one)."""

    frames: dict[CameraStatus, int]
    picture_bytes: int
    capture_ns: int


class VideoTally:
    """Counts of every camera; one process writes, others read. Create it before the fork."""

    def __init__(self, cameras: Sequence[str]) -> None:
        self.cameras = tuple(cameras)
        memory = mmap.mmap(-1, len(self.cameras) * FIELDS * COUNT_BYTES)
        self._counts = np.frombuffer(memory, dtype=np.int64).reshape(len(self.cameras), FIELDS)

    def note(self, frame: VideoFrame) -> None:
        """Count a message that was sent."""
        row = self._counts[self.cameras.index(frame.camera)]
        row[STATUSES.index(frame.status)] += 1
        row[BYTES] += len(frame.jpeg)
        if frame.status is CameraStatus.LIVE:
            row[CAPTURE_NS] = frame.capture_ns

    def read(self, camera: str) -> CameraTally:
        """The counts of one camera so far."""
        counts = self._counts[self.cameras.index(camera)].tolist()
        return CameraTally(dict(zip(STATUSES, counts, strict=False)), counts[BYTES], counts[CAPTURE_NS])
