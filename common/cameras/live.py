"""A running camera: set up and verified when it is opened, its frames stamped by its driver or by their arrival."""

from collections.abc import Callable

import cv2

from common.cameras.camera import Frame, Image
from common.cameras.controls import V4L2, CameraState, VideoCapture, check_state, read_back, set_up
from common.cameras.modes import device_of
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.cameras.shown_source import shown_source
from common.cameras.stamps import DriverStamps
from common.clock import NS_PER_MS, Clock, MonotonicClock
from common.errors import CameraError

WAITING_NS = 2 * NS_PER_MS  # a frame that comes sooner was waiting in a buffer
MOST_WAITING = 8


def open_capture(source: str) -> VideoCapture:
    """OpenCV's capture of a device or stream; devices go through V4L2 where there is one, for its units and stamps."""
    is_device = device_of(source) is not None and cv2.videoio_registry.hasBackend(cv2.CAP_V4L2)
    backend = cv2.CAP_V4L2 if is_device else cv2.CAP_ANY
    return cv2.VideoCapture(int(source) if source.isdecimal() else source, backend)


class LiveCamera:
    """A device number, device path or URL.

    Frames are stamped with the driver's time less `stamp_latency_ms`, where the driver's stamps are on this host's
    monotonic clock; else with their arrival less `latency_ms`. `state` is what the camera did when it was opened;
    `wished_fps` is asked for and not verified. Raises CameraError when the camera cannot be opened, gives no
    picture, or does otherwise than its settings ask.
    """

    def __init__(
        self,
        source: str,
        name: str,
        settings: CameraSettings = AS_IT_IS,
        wished_fps: float | None = None,
        *,
        open_source: Callable[[str], VideoCapture] = open_capture,
        clock: Clock | None = None,
    ) -> None:
        self.name = name
        self._source = shown_source(source)
        self._settings = settings
        self._clock = clock or MonotonicClock()
        self._stamps = DriverStamps()
        self._seq = 0
        self._last_ns = 0
        self._capture = open_source(source)
        if not self._capture.isOpened():
            raise CameraError(
                f"camera {name}: cannot open {self._source}; is it plugged in, and may this user read it?"
            )
        try:
            set_up(self._capture, settings, wished_fps)
            self.state: CameraState = self._verified()
        except CameraError:
            self.close()
            raise

    @property
    def stamped_by_driver(self) -> bool:
        """Whether capture times come from the driver."""
        return self._stamps.trusted

    def read(self) -> Frame | None:
        """Wait for the newest frame; CameraError when the camera delivers none."""
        if self._seq == 0:
            self._drop_waiting()
        image, arrival_ns, stamp_ns = self._next("delivers no more frames; was it unplugged?")
        if self._stamps.trusted:
            self._stamps.add(stamp_ns, arrival_ns)
        by_driver, settings = self._stamps.trusted, self._settings
        capture_ns = stamp_ns - settings.stamp_latency_ns if by_driver else arrival_ns - settings.latency_ns
        # Time never runs backwards, not even where the driver's stamps end.
        self._last_ns = max(capture_ns, self._last_ns + 1)
        frame = Frame(image, self._last_ns, self._seq, capture_estimated=not by_driver)
        self._seq += 1
        return frame

    def close(self) -> None:
        self._capture.release()

    def _verified(self) -> CameraState:
        """Read frames until the time stamps are judged, and check what the camera does."""
        no_frame = (
            "delivers no frame; does another program use it, or do two cameras share the bandwidth of one USB port "
            '(pixel_format = "MJPG" needs less)?'
        )
        image, arrival_ns, stamp_ns = self._next(no_frame)
        state = read_back(self._capture, image)
        check_state(self.name, self._source, self._settings, state)
        if self._capture.getBackendName() == V4L2:
            self._stamps.add(stamp_ns, arrival_ns)
            while self._stamps.undecided:
                _, arrival_ns, stamp_ns = self._next(no_frame)
                self._stamps.add(stamp_ns, arrival_ns)
        return state

    def _next(self, otherwise: str) -> tuple[Image, int, int]:
        """The next picture, its arrival and its driver's stamp, ns; CameraError says `otherwise`."""
        ok, image = self._capture.read()
        arrival_ns = self._clock.now_ns()
        if not ok:
            raise CameraError(f"camera {self.name}: {self._source} {otherwise}")
        stamp_ns = round(self._capture.get(cv2.CAP_PROP_POS_MSEC) * NS_PER_MS)
        return image, arrival_ns, stamp_ns  # type: ignore[return-value]  # cv2's stubs allow any dtype; a camera gives uint8

    def _drop_waiting(self) -> None:
        """Drop frames that have waited in buffers since the camera was opened: their arrival says nothing."""
        for _ in range(MOST_WAITING):
            before_ns = self._clock.now_ns()
            if not self._capture.grab() or self._clock.now_ns() - before_ns > WAITING_NS:
                return
