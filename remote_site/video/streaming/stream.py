"""One camera's stream: what to publish now, so that an old picture is never shown as live."""

from collections import deque
from collections.abc import Callable

import numpy as np

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_MS, NS_PER_S
from common.messages.video import CameraStatus, VideoFrame
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.encoding import NOTHING, Encoded, PictureEncoder
from remote_site.video.streaming.pictures import is_dark
from remote_site.video.streaming.setting import StreamSetting

SAMPLING = 4
NEVER = -1
MAX_REASON = 400
JITTER = 1.25  # a camera no quicker than this times a rate is not thinned to it
WINDOW_NS = 700 * NS_PER_MS


class FrameRate:
    """The number of pictures a second that a camera makes, by its own numbers, whether or not all were taken."""

    def __init__(self) -> None:
        self._exposures: deque[tuple[int, int]] = deque()

    def see(self, frame: Frame) -> None:
        """A new picture; numbers that start again, as after a camera was reopened, start a new count."""
        if self._exposures and frame.seq <= self._exposures[-1][1]:
            self._exposures.clear()
        self._exposures.append((frame.capture_ns, frame.seq))
        while len(self._exposures) > 1 and self._exposures[1][0] <= frame.capture_ns - WINDOW_NS:
            self._exposures.popleft()

    @property
    def fps(self) -> float | None:
        """Recent pictures a second, None before there are enough to measure it."""
        if not self._exposures:
            return None
        (first_ns, first), (last_ns, last) = self._exposures[0], self._exposures[-1]
        return (last - first) * NS_PER_S / (last_ns - first_ns) if last_ns - first_ns >= WINDOW_NS else None


class Freshness:
    """The times of a camera's last new exposure, and of its last picture that differs from the one before."""

    def __init__(self) -> None:
        self.exposure_ns = self.picture_ns = NEVER
        self._sample: Image | None = None

    def begin(self, now_ns: int) -> None:
        """Count from the first call."""
        if self.exposure_ns == NEVER:
            self.exposure_ns = self.picture_ns = now_ns

    def see(self, sample: Image, now_ns: int, *, may_repeat: bool) -> None:
        """Part of a new exposure; it may rightly be the same as the last one where `may_repeat`."""
        self.exposure_ns = now_ns
        if may_repeat or self._sample is None or not np.array_equal(sample, self._sample):
            self.picture_ns = now_ns
        self._sample = sample


class Thinning:
    """Spreads the pictures that are sent evenly over those of a quicker camera."""

    def __init__(self) -> None:
        self._due_ns = 0.0

    def takes(self, capture_ns: int, makes_fps: float, fps: float) -> bool:
        """Return whether to send this picture of a camera that makes `makes_fps`, to send `fps`."""
        if makes_fps <= JITTER * fps:
            return True
        if capture_ns < self._due_ns - NS_PER_S / makes_fps / 2:
            return False
        period_ns = NS_PER_S / fps
        self._due_ns = max(self._due_ns, capture_ns - period_ns) + period_ns
        return True


class CameraStream:
    """Numbers the frames of one camera and distinguishes its states.

    Pictures of a dark or slow camera are sent and marked; of a frozen or missing one only the status is sent. A picture
    without noise may rightly stay the same (`noise_free`, a simulated view, or a dark one); only its time stamp then
    shows whether the camera is frozen.
    """

    def __init__(self, name: str, config: VideoConfig, *, noise_free: bool) -> None:
        self._name = name
        self._config = config
        self._noise_free = noise_free
        self._frozen_ns = round(config.frozen_ms * NS_PER_MS)
        self._rate = FrameRate()
        self._freshness = Freshness()
        self._thinning = Thinning()
        self._encoder = PictureEncoder()
        self._seq = 0
        self._capture_ns = NEVER
        self._estimated = False
        self._status_ns = NEVER

    def take(
        self, frame: Frame | None, setting: StreamSetting, now_ns: int, waits: Callable[[], bool] = lambda: False
    ) -> VideoFrame | None:
        """Build what to publish at `now_ns`, given the newest frame (None before the first); None for nothing new.

        `waits` is asked for each picture that is due, which is left out while the last one still waits to be sent.
        """
        self._freshness.begin(now_ns)
        if frame is None or frame.capture_ns <= self._capture_ns:
            return self._without_new(now_ns)
        self._capture_ns, self._estimated = frame.capture_ns, frame.capture_estimated
        self._rate.see(frame)
        sample = frame.image[::SAMPLING, ::SAMPLING].copy()
        dark = is_dark(sample, self._config.dark_level)
        self._freshness.see(sample, now_ns, may_repeat=self._noise_free or dark)
        if now_ns - self._freshness.picture_ns > self._frozen_ns:
            why = "repeats the same picture; check the camera and its connection to this host"
            return self._without_picture(CameraStatus.FROZEN, f"camera {self._name} {why}", now_ns)
        self._status_ns = NEVER
        return self._with_picture(frame, setting, waits, dark=dark)

    def missing(self, reason: str, now_ns: int) -> VideoFrame | None:
        """The status of a camera that gives nothing and why, as often as configured."""
        return self._without_picture(CameraStatus.MISSING, reason, now_ns)

    def want_key_frame(self, after_seq: int) -> None:
        """A viewer cannot decode what follows this picture without a key frame."""
        self._encoder.want_key_frame(after_seq)

    def _without_new(self, now_ns: int) -> VideoFrame | None:
        silent_ns = now_ns - self._freshness.exposure_ns
        if silent_ns <= self._frozen_ns:
            return None
        silent = f"for {silent_ns / NS_PER_S:.1f} s; check its cable, its power and its address"
        if self._capture_ns == NEVER:
            return self.missing(f"camera {self._name} has given no picture yet, {silent}", now_ns)
        return self._without_picture(
            CameraStatus.FROZEN, f"camera {self._name} has given no new picture {silent}", now_ns
        )

    def _with_picture(
        self, frame: Frame, setting: StreamSetting, waits: Callable[[], bool], *, dark: bool
    ) -> VideoFrame | None:
        """The picture as the setting wants it; None for one that is left out."""
        promised_fps = self._config.fps
        if not self._thinning.takes(frame.capture_ns, self._rate.fps or promised_fps, setting.fps) or waits():
            return None
        expected_fps = min(promised_fps, setting.fps) if self._noise_free else promised_fps
        status, reason = self._status(expected_fps, dark=dark)
        encoded = self._encoder.encode(frame.image, setting, self._seq, frame.capture_ns)
        return self._message(status, reason, encoded)

    def _status(self, expected_fps: float, *, dark: bool) -> tuple[CameraStatus, str]:
        fps = self._rate.fps
        slow = fps is not None and fps < expected_fps / 2
        rate = f"camera {self._name} gives {fps:.1f} of {expected_fps:.0f} pictures a second" if slow else ""
        if dark:
            nothing = f"camera {self._name} shows nothing: is there light, is its lens free?"
            return CameraStatus.DARK, f"{nothing} {rate}".strip()
        if slow:
            cure = "this host is too busy to draw more" if self._noise_free else "check its exposure time and its cable"
            return CameraStatus.SLOW, f"{rate}; {cure}"
        return CameraStatus.LIVE, ""

    def _without_picture(self, status: CameraStatus, reason: str, now_ns: int) -> VideoFrame | None:
        if self._status_ns != NEVER and now_ns - self._status_ns < round(NS_PER_S / self._config.status_hz):
            return None
        self._status_ns = now_ns
        return self._message(status, reason[:MAX_REASON], NOTHING)

    def _message(self, status: CameraStatus, reason: str, encoded: Encoded) -> VideoFrame:
        seq, self._seq = self._seq, self._seq + 1
        return VideoFrame(
            camera=self._name,
            seq=seq,
            capture_ns=max(self._capture_ns, 0),
            capture_estimated=self._estimated,
            status=status,
            reason=reason,
            width=encoded.width,
            height=encoded.height,
            codec=encoded.codec,
            key=encoded.key,
            data=encoded.data,
        )
