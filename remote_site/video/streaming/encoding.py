"""The encoder of one camera: its pictures as the setting in force wants them, and key frames for viewers."""

from collections import deque
from typing import NamedTuple

from common.cameras.camera import Image
from common.clock import NS_PER_MS, NS_PER_S
from common.errors import ConfigError
from common.messages.video import Codec
from remote_site.video.streaming.codec_choice import CodecPreference
from remote_site.video.streaming.h264 import H264_CURE, H264Encoder, has_h264
from remote_site.video.streaming.pictures import encode_jpeg, shrunk
from remote_site.video.streaming.setting import StreamSetting, most_h264_bytes

KEY_FRAMES_A_SECOND = 2  # for whoever asks: each takes the bytes of several pictures, and the others get worse
KEY_FRAMES_APART_NS = 100 * NS_PER_MS  # one that was lost is sent again soon
NEVER, LONG_AGO_NS = -1, -NS_PER_S


class Encoded(NamedTuple):
    """A picture as it is sent, with its size in pixels; empty without one."""

    codec: Codec
    key: bool
    width: int
    height: int
    data: bytes


NOTHING = Encoded(Codec.JPEG, False, 0, 0, b"")


def can_encode(codec: CodecPreference) -> bool:
    """Return whether H.264 can be sent where it is asked for; ConfigError where only it will do and PyAV is missing."""
    if codec is CodecPreference.H264 and not has_h264():
        raise ConfigError(f"video.codec = 'h264' needs PyAV, which is not installed; {H264_CURE}")
    return codec is not CodecPreference.JPEG and has_h264()


class PictureEncoder:
    """JPEG, or H.264 by an encoder that is opened again for another size or rate.

    All requests for a key frame after pictures sent before the last one are answered by it. In any second at most
    KEY_FRAMES_A_SECOND are made because somebody asks.
    """

    def __init__(self) -> None:
        self._h264: H264Encoder | None = None
        self._opened_for: tuple[int, int, int] | None = None
        self._keys_ns: deque[int] = deque([LONG_AGO_NS] * KEY_FRAMES_A_SECOND, KEY_FRAMES_A_SECOND)
        self._key_seq = self._wanted_after = NEVER

    def want_key_frame(self, after_seq: int) -> None:
        """A viewer cannot decode the pictures after this one without a key frame."""
        self._wanted_after = max(self._wanted_after, after_seq)

    def encode(self, image: Image, setting: StreamSetting, seq: int, t_ns: int) -> Encoded:
        """The picture of this number, exposed at `t_ns`; CameraError where H.264 cannot be encoded here."""
        image = shrunk(image, setting.scale)
        if setting.codec is Codec.JPEG:
            self._h264 = self._opened_for = None
            return Encoded(Codec.JPEG, True, image.shape[1], image.shape[0], encode_jpeg(image, setting.quality))
        height, width = image.shape[0] // 2 * 2, image.shape[1] // 2 * 2  # colours have half the resolution
        encoder = self._opened(width, height, setting.picture_bytes or most_h264_bytes(width * height))
        first_ns, last_ns = self._keys_ns[0], self._keys_ns[-1]
        due = t_ns - first_ns >= NS_PER_S and t_ns - last_ns >= KEY_FRAMES_APART_NS
        data, key = encoder.encode(image[:height, :width], key=self._wanted_after >= self._key_seq and due)
        if key:
            self._key_seq, self._wanted_after = seq, NEVER
            self._keys_ns.append(t_ns)
        return Encoded(Codec.H264, key, width, height, data)

    def _opened(self, width: int, height: int, picture_bytes: int) -> H264Encoder:
        wanted = width, height, picture_bytes
        if self._h264 is None or self._opened_for != wanted:
            self._h264, self._opened_for = H264Encoder(*wanted), wanted
        return self._h264
