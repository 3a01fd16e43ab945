"""Decodes one camera's pictures as they come, JPEG or H.264; nothing after a gap until a key frame."""

from typing import TYPE_CHECKING

import numpy as np
import simplejpeg

from common.cameras.camera import Image
from common.messages.continuity import Continuity
from common.messages.video import Codec, VideoFrame

if TYPE_CHECKING:
    from av import VideoCodecContext


class PictureDecoder:
    """One camera's; `wants_after` is the number of the picture after which it needs a key frame, None without need."""

    def __init__(self) -> None:
        self._continuity = Continuity()
        self._h264: VideoCodecContext | None = None

    @property
    def wants_after(self) -> int | None:
        """The number of the picture after which it needs a key frame; None without need."""
        return self._continuity.wants_after

    def decode(self, frame: VideoFrame) -> Image | None:
        """The picture (H, W, 3), BGR; None where there is none, or it cannot be decoded."""
        whole = self._continuity.take(frame.seq, is_picture=bool(frame.data), key=frame.key)
        if not whole or not frame.data:
            return None
        if frame.codec is Codec.JPEG:
            return np.asarray(simplejpeg.decode_jpeg(frame.data, colorspace="BGR"), dtype=np.uint8)
        return self._decode_h264(frame)

    def _decode_h264(self, frame: VideoFrame) -> Image | None:
        import av  # noqa: PLC0415  # an extra of the installation

        if frame.key or self._h264 is None:
            self._h264 = av.CodecContext.create("h264", "r")
            self._h264.thread_count = 1
        try:
            pictures = self._h264.decode(av.Packet(frame.data))
        except av.error.InvalidDataError:
            pictures = []
        if not pictures:
            self._continuity.interrupt()
            return None
        return np.asarray(pictures[-1].to_ndarray(format="bgr24"), dtype=np.uint8)
