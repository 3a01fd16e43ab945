"""A real camera, or a recording played in its stead, read by a thread that keeps only the newest frame."""

import threading
import time
from collections.abc import Callable
from dataclasses import replace

from common.cameras.camera import Camera, Frame
from common.cameras.opencv import LiveCamera
from common.clock import NS_PER_S
from common.errors import CameraError

REOPEN_S = 2.0


class ThreadedCamera:
    """Opens a camera, reads it as fast as it gives, and opens it again when it fails."""

    noise_free = False

    def __init__(self, name: str, open_it: Callable[[], Camera]) -> None:
        self.name = name
        self._open_it = open_it
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
        try:
            while not self._ended.is_set():
                frame = camera.read()
                if frame is None:
                    raise CameraError(f"camera {self.name}: the recording has ended")
                self._keep(frame, start_ns)
        finally:
            camera.close()

    def _keep(self, frame: Frame, start_ns: int) -> None:
        capture_ns = start_ns + frame.capture_ns
        self._ended.wait(max(0.0, (capture_ns - time.monotonic_ns()) / NS_PER_S))
        self._frame = replace(frame, capture_ns=capture_ns)
