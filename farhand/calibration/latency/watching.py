"""Reads a camera in a thread and keeps the time stamps of its frames and how bright they were, part by part."""

import threading
from collections import deque
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Camera, Frame
from common.errors import CalibrationError, CameraError
from common.geometry import Array

PARTS = (64, 48)
MOST_FRAMES = 10_000  # more than the pattern takes at 240 frames a second
LINGER_S = 1.0
OF_GREATEST = 0.5


@dataclass(frozen=True, slots=True)
class WatchedFrames:
    """Frames: time stamps (n,), ns; brightness (n, 48, 64) of their parts; whether the driver gave the stamps."""

    stamps_ns: NDArray[np.int64]
    parts: Array
    stamped_by_driver: bool

    @property
    def brightness(self) -> Array:
        """The mean brightness (n,) of the parts that change most: the screen."""
        change = self.parts.std(axis=0)
        return np.asarray(self.parts[:, change >= OF_GREATEST * change.max()].mean(axis=1))


class Watch:
    """Reads a camera until it is stopped, or ends."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self._frames: deque[tuple[int, bool, Array]] = deque(maxlen=MOST_FRAMES)
        self._stopped = threading.Event()
        self._failure: CameraError | None = None
        self._thread = threading.Thread(target=self._read, name=f"camera {camera.name}", daemon=True)
        self._thread.start()

    @property
    def failure(self) -> CameraError | None:
        """Why the camera gives no more frames; None while it does."""
        return self._failure

    def stop(self) -> WatchedFrames:
        """Wait for the frames on their way, and return all; CalibrationError when the driver's stamps ended."""
        self._thread.join(LINGER_S)
        self._stopped.set()
        self._thread.join(LINGER_S)
        stamps, estimated, parts = zip(*self._frames, strict=True) if self._frames else ((), (), ())
        if len(set(estimated)) > 1:
            raise CalibrationError("its driver's time stamps went wrong meanwhile; measure again")
        return WatchedFrames(np.array(stamps, dtype=np.int64), np.array(parts, dtype=float), not any(estimated))

    def _read(self) -> None:
        try:
            while not self._stopped.is_set() and (frame := self._camera.read()) is not None:
                self._frames.append((frame.capture_ns, frame.capture_estimated, _parts(frame)))
        except CameraError as error:
            self._failure = error


def _parts(frame: Frame) -> Array:
    small = cv2.resize(frame.image, PARTS, interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8) if small.ndim == 2 else np.asarray(small.mean(axis=2), dtype=np.uint8)
