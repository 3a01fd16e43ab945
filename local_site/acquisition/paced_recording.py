"""A recording in the place of a live camera: its frames come at their own pace, stamped by this host's clock."""

import threading
from dataclasses import replace

from common.cameras.camera import Camera, Frame
from common.cameras.sources import damage_of
from common.clock import Clock
from common.errors import CameraError


class RecordingStart:
    """When the recordings of a rig began: all together, as soon as the first of them is read."""

    def __init__(self, clock: Clock) -> None:
        self._clock, self._lock = clock, threading.Lock()
        self._start_ns: int | None = None

    def wait_until(self, since_start_ns: int) -> int:
        """Wait until so long after the start; the time then, ns."""
        with self._lock:
            self._start_ns = self._clock.now_ns() if self._start_ns is None else self._start_ns
        due_ns = self._start_ns + since_start_ns
        self._clock.sleep_until_ns(due_ns)
        return due_ns


class PacedRecording:
    """One camera's recording."""

    def __init__(self, recording: Camera, start: RecordingStart) -> None:
        self._recording, self._start = recording, start

    @property
    def name(self) -> str:
        """The camera's name."""
        return self._recording.name

    def read(self) -> Frame | None:
        """Wait for the next frame; None at the end, CameraError at that of a damaged file."""
        frame = self._recording.read()
        if frame is not None:
            return replace(frame, capture_ns=self._start.wait_until(frame.capture_ns))
        if damage := damage_of(self._recording):
            raise CameraError(damage)
        return None

    def close(self) -> None:
        """Close the recording."""
        self._recording.close()
