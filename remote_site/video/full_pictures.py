"""Every picture of the cell in full quality, for a recorder of this host, whatever the link shows the operator."""

from typing import Protocol

from common.cameras.camera import Frame
from common.messages.video import Codec, VideoFrame
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import encode_jpeg
from remote_site.video.streaming.setting import StreamSetting

NEVER = -1  # earlier than any exposure, ns


class PictureKeeper(Protocol):
    """Keeps full pictures, and notes each frame that was sent; `is_full`: its bytes are those of the full picture."""

    def is_watched(self) -> bool: ...

    def keep(self, camera: str, frame: Frame, data: bytes) -> None: ...

    def note_frame(self, frame: VideoFrame, *, is_full: bool) -> None: ...


class FullPictures:
    """Encodes each exposure once in the configured quality, and not again where it was sent so."""

    def __init__(self, config: VideoConfig, keeper: PictureKeeper) -> None:
        self._quality, self._keeper = config.quality, keeper
        self._kept_ns: dict[str, int] = {}

    @property
    def wanted(self) -> bool:
        """Return whether anybody takes the pictures."""
        return self._keeper.is_watched()

    def see(self, camera: str, frame: Frame | None, sent: VideoFrame | None, setting: StreamSetting) -> None:
        """Keep the newest exposure of a camera, if it is new, and note the frame `sent` under this setting, if any."""
        whole = sent.data if sent is not None and frame is not None and self._is_full(sent, frame, setting) else b""
        if frame is not None and frame.capture_ns > self._kept_ns.get(camera, NEVER):
            self._kept_ns[camera] = frame.capture_ns
            self._keeper.keep(camera, frame, whole or encode_jpeg(frame.image, self._quality))
        if sent is not None:
            self._keeper.note_frame(sent, is_full=bool(whole))

    def _is_full(self, sent: VideoFrame, frame: Frame, setting: StreamSetting) -> bool:
        same = sent.capture_ns == frame.capture_ns and sent.codec is Codec.JPEG
        return same and setting.scale >= 1.0 and setting.quality >= self._quality
