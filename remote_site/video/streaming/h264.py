"""H.264 of one camera by x264: no picture waits for another, none is much larger than the link takes in its time."""

from fractions import Fraction
from importlib.util import find_spec
from typing import NamedTuple

import cv2
import numpy as np

from common.cameras.camera import Image
from common.errors import CameraError

H264_CURE = "pip install 'farhand[video]'"
NOMINAL_FPS = 30  # of the rate control alone, which counts pictures: their bytes matter, not when they are taken
BUFFER_PICTURES = 2.0  # a key frame may be this many times as large as an average picture, so that nothing queues
QUALITY = 20  # constant rate factor: no better than this, whatever the link carries
NEVER = 1 << 30
X264 = "scenecut=0:keyint=infinite:colorprim=smpte170m:transfer=smpte170m:colormatrix=smpte170m"


class EncodedPicture(NamedTuple):
    """A picture as it is sent: in Annex B, with the parameter sets if it is a key frame."""

    data: bytes
    key: bool


def has_h264() -> bool:
    """Return whether PyAV is installed."""
    return find_spec("av") is not None


class H264Encoder:
    """Encodes pictures of `width` x `height`, even numbers, in at most `picture_bytes` on average, best effort.

    Constrained baseline profile, one thread; CameraError where PyAV or its x264 is missing. The rate cannot be changed
    through PyAV while it runs: open another, which begins with a key frame.
    """

    def __init__(self, width: int, height: int, picture_bytes: int) -> None:
        try:
            import av  # noqa: PLC0415  # an extra of the installation, loaded only where it is used

            self._context = av.CodecContext.create("libx264", "w")
        except (ImportError, ValueError) as error:
            raise CameraError(f"H.264 needs PyAV with x264 ({error}); {H264_CURE}") from error
        self._av = av
        context, bits_per_s = self._context, 8 * picture_bytes * NOMINAL_FPS
        context.width, context.height, context.pix_fmt = width, height, "yuv420p"
        context.time_base, context.framerate = Fraction(1, NOMINAL_FPS), Fraction(NOMINAL_FPS)
        context.thread_count, context.gop_size = 1, NEVER
        context.options = {
            "preset": "ultrafast",
            "tune": "zerolatency",
            "crf": str(QUALITY),
            "maxrate": str(bits_per_s),
            "bufsize": str(round(bits_per_s / NOMINAL_FPS * BUFFER_PICTURES)),
            "forced-idr": "1",
            "x264-params": X264,
        }
        context.open()
        self._count = 0

    def encode(self, image: Image, *, key: bool) -> EncodedPicture:
        """A grey (H, W) or BGR (H, W, 3) picture, as a key frame if asked; the first always is one."""
        frame = self._av.VideoFrame.from_ndarray(_planes(image), format="yuv420p")
        frame.pts, self._count = self._count, self._count + 1
        picture_type = self._av.video.frame.PictureType
        frame.pict_type = picture_type.I if key else picture_type.NONE
        packets = self._context.encode(frame)
        return EncodedPicture(b"".join(bytes(packet) for packet in packets), any(p.is_keyframe for p in packets))


def _planes(image: Image) -> Image:
    """Luminance and both colour planes, BT.601 in limited range, one below the other: (3 H / 2, W)."""
    if image.ndim == 2:
        image = np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_BGR2YUV_I420), dtype=np.uint8)
