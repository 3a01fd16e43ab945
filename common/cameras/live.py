"""A running camera: set up and verified when it is opened, its frames stamped by its driver or by their arrival."""

import math
import os
from collections.abc import Callable
from typing import TypeGuard

import cv2
import numpy as np
import structlog

from common.cameras.camera import Frame, Image
from common.cameras.controls import V4L2, CameraState, VideoCapture, check_state, read_back, set_up
from common.cameras.given_rate import GivenRate
from common.cameras.modes import device_of
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.cameras.shown_source import shown_source
from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import CameraError
from common.host_clock import MonotonicClock

WAITING_NS = 2 * NS_PER_MS  # a frame that comes sooner was waiting in a buffer
MOST_WAITING = 8
GIVEN_UP_NS = 2 * NS_PER_S  # without a picture
RETRY_NS = 10 * NS_PER_MS  # a source that is gone says so at once, again and again
CURE_OF_RATE = "give more light or a fixed exposure_ms, a port of its own, or pixel_format = 'MJPG'"
FRAMES_TO_TRUST = 5
FFMPEG_QUIET = "-8"
OLDEST_NS = 500 * NS_PER_MS  # a few buffers of a slow camera; another clock is hours or decades away


class DriverStamps:
    """Trusts the stamps after FRAMES_TO_TRUST good ones in a row, and never again after a bad one.

    A stamp is good if it is later than the last, not later than the frame's arrival, and at most half a second
    older than it. Times are ns on this host's monotonic clock.
    """

    def __init__(self) -> None:
        self._last_ns = 0
        self._good = 0
        self._broken = False

    @property
    def trusted(self) -> bool:
        """Return whether frames may take their capture time from the driver."""
        return self._good >= FRAMES_TO_TRUST and not self._broken

    @property
    def undecided(self) -> bool:
        """Return whether more frames are needed to judge."""
        return self._good < FRAMES_TO_TRUST and not self._broken

    def add(self, stamp_ns: int, arrival_ns: int) -> None:
        """Take the stamp of the next frame, and when the frame arrived."""
        if self._last_ns < stamp_ns <= arrival_ns and arrival_ns - stamp_ns <= OLDEST_NS:
            self._good += 1
        else:
            self._broken = True
        self._last_ns = stamp_ns


def open_capture(source: str) -> VideoCapture:
    """OpenCV's capture of a device or stream; devices go through V4L2 where there is one, for its units and stamps.

    Streams go through FFmpeg alone: OpenCV's reader of numbered pictures would print a URL, password and all, that has
    a percent sign. FFmpeg prints nothing, for the same reason, and OpenCV no warnings: the caller says what fails.
    """
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", FFMPEG_QUIET)
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
    backend = cv2.CAP_ANY
    if device_of(source) is not None and cv2.videoio_registry.hasBackend(cv2.CAP_V4L2):
        backend = cv2.CAP_V4L2
    elif "://" in source and cv2.videoio_registry.hasBackend(cv2.CAP_FFMPEG):
        backend = cv2.CAP_FFMPEG
    return cv2.VideoCapture(int(source) if source.isdecimal() else source, backend)


class LiveCamera:
    """A device number, device path or URL.

    Frames are stamped with the driver's time less `stamp_latency_ms`, where the driver's stamps are on this host's
    monotonic clock; else with their arrival less `latency_ms`. `state` is what the camera did when it was opened;
    `wished_fps` is asked for and not verified. Raises CameraError when the camera cannot be opened, gives no
    picture, or does otherwise than its settings ask.

    A picture that does not come, or is none of the camera's size, is skipped and counted (`lost`); after GIVEN_UP_NS
    without one the camera has failed. The log says the first that is lost, and when fewer come than the camera states.
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
        self._seq = self._last_ns = self.lost = 0
        self._is_closed = False
        self._capture = open_source(source)
        if not self._capture.isOpened():
            cure = "are address, path and password right?" if "://" in source else "may this user read it?"
            raise CameraError(f"camera {name}: cannot open {self._source}; is it plugged in, and {cure}")
        try:
            set_up(self._capture, settings, wished_fps)
            self.state: CameraState = self._verified()
            self._rate = GivenRate(self.state.fps)
        except CameraError:
            self.close()
            raise

    @property
    def stamped_by_driver(self) -> bool:
        """Return whether capture times come from the driver."""
        return self._stamps.trusted

    def read(self) -> Frame | None:
        """Wait for the newest frame; CameraError when the camera delivers none for GIVEN_UP_NS."""
        if self._seq == 0:
            self._drop_waiting()
        asked_ns = self._clock.now_ns()
        image, arrival_ns, stamp_ns = self._next("delivers no more frames; was it unplugged?", self.state.size_px)
        self._watch_rate(arrival_ns, arrival_ns - asked_ns)
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
        self._is_closed = True
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

    def _next(self, otherwise: str, size_px: tuple[int, int] | None = None) -> tuple[Image, int, int]:
        """The next picture, its arrival and its driver's stamp, ns; CameraError says `otherwise`."""
        give_up_ns = self._clock.now_ns() + GIVEN_UP_NS
        while (image := self._read_one(size_px)) is None:
            self._lose()
            if self._is_closed or self._clock.now_ns() >= give_up_ns:
                raise CameraError(f"camera {self.name}: {self._source} {otherwise}")
            self._clock.sleep_until_ns(self._clock.now_ns() + RETRY_NS)
        arrival_ns, stamp_ms = self._clock.now_ns(), self._capture.get(cv2.CAP_PROP_POS_MSEC)
        return image, arrival_ns, round(stamp_ms * NS_PER_MS) if math.isfinite(stamp_ms) else 0

    def _read_one(self, size_px: tuple[int, int] | None) -> Image | None:
        """A picture of this size, of any where it is None; None where none came."""
        try:
            ok, image = self._capture.read()
        except cv2.error:  # what came could not be decoded
            return None
        return image if ok and _is_picture(image, size_px) else None

    def _lose(self) -> None:
        self.lost += 1
        if self.lost == 1:
            cure = "a few are skipped; where they are many, look at its cable and its port"
            structlog.get_logger().warning("a picture was lost", camera=self.name, cure=cure)

    def _watch_rate(self, now_ns: int, waited_ns: int) -> None:
        """Say when the camera begins to give fewer pictures than it states, and when it gives them again."""
        was_slow = self._rate.slow_fps is not None
        self._rate.note(now_ns, waited_ns)
        slow_fps = self._rate.slow_fps
        if (slow_fps is not None) == was_slow:
            return
        log, stated = structlog.get_logger(), f"{self.state.fps:g}"
        if slow_fps is None:
            log.info("a camera gives as many pictures as it states", camera=self.name, fps=stated)
        else:
            given = f"{slow_fps:.1f}"
            log.warning(
                "a camera gives too few pictures", camera=self.name, fps=given, stated=stated, cure=CURE_OF_RATE
            )

    def _drop_waiting(self) -> None:
        """Drop frames that have waited in buffers since the camera was opened: their arrival says nothing."""
        for _ in range(MOST_WAITING):
            before_ns = self._clock.now_ns()
            if not self._capture.grab() or self._clock.now_ns() - before_ns > WAITING_NS:
                return


def _is_picture(image: object, size_px: tuple[int, int] | None) -> TypeGuard[Image]:
    """Check that this is (H, W) or (H, W, 3), uint8, and of the size."""
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8 or not image.size:
        return False
    is_grey, is_colour = image.ndim == 2, image.ndim == 3 and image.shape[2] == 3
    return (is_grey or is_colour) and size_px in (None, (image.shape[1], image.shape[0]))
