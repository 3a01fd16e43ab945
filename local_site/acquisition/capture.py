"""Reads one to n cameras, each in a thread of its own, and gives the newest views of a common instant."""

import threading
from collections.abc import Sequence

from common.cameras.camera import Camera
from common.cameras.lost_pictures import LostPictures
from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import CameraError
from local_site.acquisition.pairing import Pairing, PairingConfig
from local_site.tracking.tracker import Views

FRAME_S, JOIN_S = 0.2, 1.0


class Capture:
    """Live cameras, paired to views; views that were not taken in time are replaced by newer ones.

    `longest_wait_s` is how long to wait for views, as configured; what cameras lose is counted in `lost`.
    """

    def __init__(
        self, cameras: Sequence[Camera], config: PairingConfig, clock: Clock, lost: LostPictures | None = None
    ) -> None:
        self._cameras = tuple(cameras)
        self._clock = clock
        self._lost = lost or LostPictures([camera.name for camera in cameras])
        self.longest_wait_s = config.longest_wait_ms * NS_PER_MS / NS_PER_S
        self._pairing = Pairing([camera.name for camera in cameras], config, clock.now_ns())
        self._changed = threading.Condition()
        self._newest: Views | None = None
        self._failure: str | None = None
        self._reading = len(self._cameras)
        self._closing = False
        self._threads = [
            threading.Thread(target=self._read, args=(k,), name=f"camera {camera.name}", daemon=True)
            for k, camera in enumerate(self._cameras)
        ]
        for thread in self._threads:
            thread.start()

    def next(self, timeout_s: float) -> Views | None:
        """Wait for new views; None after the time-out or when a camera ended: `problem` gives the reason."""
        with self._changed:
            self._changed.wait_for(lambda: self._newest is not None or self.ended, timeout_s)
            views, self._newest = self._newest, None
            return views

    def problem(self) -> str | None:
        """Say why there are no views, in a sentence; None when all is well."""
        with self._changed:
            return self._failure or self._pairing.problem(self._clock.now_ns())

    @property
    def ended(self) -> bool:
        """Return whether a camera has failed or come to its end, so that no more views will come."""
        return self._reading < len(self._cameras)

    def close(self) -> None:
        """Let the threads end with the frame that they read, and close the cameras.

        A camera is closed while it is read only if that takes too long: OpenCV's may crash then.
        """
        self._closing = True
        for camera, thread in zip(self._cameras, self._threads, strict=True):
            thread.join(FRAME_S)
            camera.close()
        for thread in self._threads:
            thread.join(JOIN_S)

    def _read(self, k: int) -> None:
        camera = self._cameras[k]
        failure, note_lost = (
            f"camera {camera.name} has come to its end",
            self._lost.follow(self._lost.cameras[k], camera),
        )
        try:
            while not self._closing and (frame := camera.read()) is not None:
                note_lost()
                with self._changed:
                    views = self._pairing.feed(k, frame)
                    if views is not None:
                        self._newest = views
                        self._changed.notify_all()
        except CameraError as error:
            failure = str(error)
        note_lost()
        with self._changed:
            self._failure = self._failure or failure
            self._reading -= 1
            self._changed.notify_all()
