"""One camera's stream: what to publish now, so that an old picture is never shown as live. Pure."""

import numpy as np

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_MS, NS_PER_S
from common.messages import CameraStatus, VideoFrame
from remote_site.video.config import VideoConfig
from remote_site.video.encode import encode_jpeg

SAMPLING = 4
NEVER = -1
MAX_REASON = 400


class CameraStream:
    """Numbers the frames of one camera and tells frozen and missing from live.

    A picture that shows no noise may rightly stay the same (`noise_free`, a simulated view); only its time stamp then
    tells whether it is frozen.
    """

    def __init__(self, name: str, config: VideoConfig, *, noise_free: bool) -> None:
        self._name = name
        self._noise_free = noise_free
        self._quality = config.quality
        self._frozen_ns = round(config.frozen_ms * NS_PER_MS)
        self._status_period_ns = round(NS_PER_S / config.status_hz)
        self._seq = 0
        self._capture_ns = NEVER
        self._estimated = False
        self._sample: Image | None = None
        self._began_ns = NEVER
        self._new_stamp_ns = NEVER
        self._new_picture_ns = NEVER
        self._told_ns = NEVER

    def take(self, frame: Frame | None, now_ns: int) -> VideoFrame | None:
        """What to publish at `now_ns`, given the newest frame (None before the first); None for nothing new."""
        if self._began_ns == NEVER:
            self._began_ns = self._new_stamp_ns = self._new_picture_ns = now_ns
        if frame is None or frame.capture_ns <= self._capture_ns:
            return self._without_new(now_ns)
        self._capture_ns, self._new_stamp_ns = frame.capture_ns, now_ns
        self._estimated = frame.capture_estimated
        self._notice_change(frame.image, now_ns)
        if now_ns - self._new_picture_ns > self._frozen_ns:
            return self._word(
                CameraStatus.FROZEN, f"camera {self._name} gives the same picture again and again", now_ns
            )
        self._told_ns = NEVER
        height, width = frame.image.shape[:2]
        return self._message(CameraStatus.LIVE, "", width, height, encode_jpeg(frame.image, self._quality))

    def missing(self, reason: str, now_ns: int) -> VideoFrame | None:
        """The word that the camera gives nothing and why, as often as configured."""
        return self._word(CameraStatus.MISSING, reason, now_ns)

    def _without_new(self, now_ns: int) -> VideoFrame | None:
        silent_ns = now_ns - self._new_stamp_ns
        if silent_ns <= self._frozen_ns:
            return None
        if self._capture_ns == NEVER:
            return self.missing(
                f"camera {self._name} has given no picture yet, for {silent_ns / NS_PER_S:.1f} s", now_ns
            )
        return self._word(
            CameraStatus.FROZEN,
            f"camera {self._name} has given no new picture for {silent_ns / NS_PER_S:.1f} s",
            now_ns,
        )

    def _notice_change(self, image: Image, now_ns: int) -> None:
        sample = image[::SAMPLING, ::SAMPLING].copy()
        if self._noise_free or self._sample is None or not np.array_equal(sample, self._sample):
            self._new_picture_ns = now_ns
        self._sample = sample

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
