"""Cameras that send H.264, as the remote site would: the time drawn into each picture, key frames on request."""

import time
from collections.abc import Sequence

import msgspec
import numpy as np

from common.clock import NS_PER_MS
from common.messages.video import Codec, KeyFrameRequest, VideoFrame
from lab.measure.page import scene
from lab.stage.clock_strip import draw_clock
from remote_site.video.streaming.encoding import PictureEncoder
from remote_site.video.streaming.setting import StreamSetting

AGE_NS = 20 * NS_PER_MS
FULL = StreamSetting(80, 1.0, 30.0, Codec.H264)


class H264Cameras:
    """`loses` are the cameras whose pictures are lost for now, `spoils` those whose bytes are.

    Without `answers` no request is heard.
    """

    def __init__(self, requests: Sequence[KeyFrameRequest]) -> None:
        self.setting = FULL
        self.loses: set[str] = set()
        self.spoils: set[str] = set()
        self.answers = True
        self._requests, self._heard = requests, len(requests)
        self._encoders = {camera: PictureEncoder() for camera in scene.CAMERAS}

    def picture(self, camera: str, seq: int) -> VideoFrame | None:
        """The camera's next picture; None for one that is lost on the way."""
        for request in self._requests[self._heard :] if self.answers else ():
            self._encoders[request.camera].want_key_frame(request.after_seq)
        self._heard = len(self._requests)
        image, exposed_ns = np.full((*scene.SIZE, 3), 120, np.uint8), time.monotonic_ns() - AGE_NS
        draw_clock(image, exposed_ns)
        encoded = self._encoders[camera].encode(image, self.setting, seq, exposed_ns)
        if camera in self.loses:
            return None
        return msgspec.structs.replace(
            scene.picture(camera, seq, b""),
            capture_ns=exposed_ns,
            width=encoded.width,
            height=encoded.height,
            codec=encoded.codec,
            key=encoded.key,
            data=bytes(len(encoded.data)) if camera in self.spoils else encoded.data,
        )
