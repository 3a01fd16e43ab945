"""One camera's stream: what to publish now, so that an old picture is never shown as live. Pure."""

import numpy as np

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_MS, NS_PER_S
from common.messages.video import CameraStatus, VideoFrame
from remote_site.video.config import VideoConfig
from remote_site.video.encode import encode_jpeg, shrunk
from remote_site.video.looks import FrameRate, is_dark
from remote_site.video.setting import StreamSetting

SAMPLING = 4
NEVER = -1
MAX_REASON = 400
ROOM_FOR_JITTER = 1.25


class CameraStream:
    """Numbers the frames of one camera and tells its states apart.

    Pictures of a dark or slow camera are sent and marked; of a frozen or missing one there is only the word. A picture
    that shows no noise may rightly stay the same (`noise_free`, a simulated view, or a dark one); only its time stamp
    then tells whether it is frozen.
    """

    def __init__(self, name: str, config: VideoConfig, *, noise_free: bool) -> None:
        self._name = name
        self._noise_free = noise_free
        self._dark_level = config.dark_level
        self._promised_fps = config.fps
        self._frozen_ns = round(config.frozen_ms * NS_PER_MS)
        self._status_period_ns = round(NS_PER_S / config.status_hz)
        self._pace = FrameRate()
        self._seq = 0
        self._capture_ns = NEVER
        self._due_ns = 0.0
        self._estimated = False
        self._sample: Image | None = None
        self._began_ns = NEVER
        self._new_stamp_ns = NEVER
        self._new_picture_ns = NEVER
        self._told_ns = NEVER

    def take(self, frame: Frame | None, setting: StreamSetting, now_ns: int) -> VideoFrame | None:
        """What to publish at `now_ns`, given the newest frame (None before the first); None for nothing new."""
        if self._began_ns == NEVER:
            self._began_ns = self._new_stamp_ns = self._new_picture_ns = now_ns
        if frame is None or frame.capture_ns <= self._capture_ns:
            return self._without_new(now_ns)
        self._capture_ns, self._new_stamp_ns = frame.capture_ns, now_ns
        self._estimated = frame.capture_estimated
        self._pace.see(frame)
        dark = self._notice(frame.image, now_ns)
        if now_ns - self._new_picture_ns > self._frozen_ns:
            why = "gives the same picture again and again; check the camera, and what is between it and this host"
            return self._word(CameraStatus.FROZEN, f"camera {self._name} {why}", now_ns)
        self._told_ns = NEVER
        return self._picture(frame, setting, dark=dark)

    def missing(self, reason: str, now_ns: int) -> VideoFrame | None:
        """The word that the camera gives nothing and why, as often as configured."""
        return self._word(CameraStatus.MISSING, reason, now_ns)

    def _without_new(self, now_ns: int) -> VideoFrame | None:
        silent_ns = now_ns - self._new_stamp_ns
        if silent_ns <= self._frozen_ns:
            return None
        silent = f"for {silent_ns / NS_PER_S:.1f} s; check its cable, its power and its address"
        if self._capture_ns == NEVER:
            return self.missing(f"camera {self._name} has given no picture yet, {silent}", now_ns)
        return self._word(CameraStatus.FROZEN, f"camera {self._name} has given no new picture {silent}", now_ns)

    def _notice(self, image: Image, now_ns: int) -> bool:
        """Whether the picture is dark; also notes when it last was another than before."""
        sample = image[::SAMPLING, ::SAMPLING].copy()
        dark = is_dark(sample, self._dark_level)
        if self._noise_free or dark or self._sample is None or not np.array_equal(sample, self._sample):
            self._new_picture_ns = now_ns
        self._sample = sample
        return dark

    def _picture(self, frame: Frame, setting: StreamSetting, *, dark: bool) -> VideoFrame | None:
        """The picture as the setting wants it; None for one that it leaves out."""
        if not self._is_due(frame.capture_ns, setting.fps):
            return None
        promised = min(self._promised_fps, setting.fps) if self._noise_free else self._promised_fps
        status, reason = self._standing(promised, dark=dark)
        image = shrunk(frame.image, setting.scale)
        height, width = image.shape[:2]
        return self._message(status, reason, width, height, encode_jpeg(image, setting.quality))

    def _is_due(self, capture_ns: int, fps: float) -> bool:
        """Whether this picture is one of so many a second, spread evenly over a quicker camera's."""
        makes_fps = self._pace.fps or self._promised_fps
        if makes_fps <= ROOM_FOR_JITTER * fps:
            return True
        if capture_ns < self._due_ns - NS_PER_S / makes_fps / 2:
            return False
        period_ns = NS_PER_S / fps
        self._due_ns = max(self._due_ns, capture_ns - period_ns) + period_ns
        return True

    def _standing(self, promised: float, *, dark: bool) -> tuple[CameraStatus, str]:
        fps = self._pace.fps
        slow = fps is not None and fps < promised / 2
        rate = f"camera {self._name} gives {fps:.1f} of {promised:g} pictures a second" if slow else ""
        if dark:
            nothing = f"camera {self._name} shows nothing: is there light, is its lens free?"
            return CameraStatus.DARK, f"{nothing} {rate}".strip()
        if slow:
            return CameraStatus.SLOW, f"{rate}; check its exposure time and its link"
        return CameraStatus.LIVE, ""

    def _word(self, status: CameraStatus, reason: str, now_ns: int) -> VideoFrame | None:
        if self._told_ns != NEVER and now_ns - self._told_ns < self._status_period_ns:
            return None
        self._told_ns = now_ns
        return self._message(status, reason[:MAX_REASON], 0, 0, b"")

    def _message(self, status: CameraStatus, reason: str, width: int, height: int, jpeg: bytes) -> VideoFrame:
        seq, self._seq = self._seq, self._seq + 1
        return VideoFrame(
            camera=self._name,
            seq=seq,
            capture_ns=max(self._capture_ns, 0),
            capture_estimated=self._estimated,
            status=status,
            reason=reason,
            width=width,
            height=height,
            jpeg=jpeg,
        )
