"""Pictures encoded as the remote site does, decoded again, and how close they are to their source."""

import time
from collections import defaultdict

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.clock import NS_PER_S
from farhand.loopback.picture_decoder import PictureDecoder
from lab.measure.video.link import live_frame
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.encoding import Encoded, PictureEncoder
from remote_site.video.streaming.setting import StreamSetting

WINDOW_PX, WINDOW_SIGMA_PX = (11, 11), 1.5
C1, C2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2  # keep the quotients finite where a picture is dark or even
COMPARED_EVERY = 15  # pictures of a camera: comparing takes longer than encoding


def ssim(a: Image, b: Image) -> float:
    """Compute the structural similarity of the brightness of two BGR pictures, 1 where they are equal.

    Source: Wang, Bovik, Sheikh and Simoncelli, Image quality assessment, IEEE Trans. Image Processing 13 (2004).
    """
    x, y = (cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(np.float64) for picture in (a, b))
    mean_x, mean_y = _windowed(x), _windowed(y)
    var_x, var_y = _windowed(x * x) - mean_x**2, _windowed(y * y) - mean_y**2
    covariance = _windowed(x * y) - mean_x * mean_y
    alike = (2 * mean_x * mean_y + C1) * (2 * covariance + C2)
    return float((alike / ((mean_x**2 + mean_y**2 + C1) * (var_x + var_y + C2))).mean())


def _windowed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(cv2.GaussianBlur(values, WINDOW_PX, WINDOW_SIGMA_PX), dtype=np.float64)


class CodedCameras:
    """An encoder and a decoder for each camera.

    `ssims` are the similarities of the pictures that were compared, `encode_ms` the processor times of all.
    """

    def __init__(self, config: VideoConfig, pictures: dict[str, list[Image]]) -> None:
        self.ssims: list[float] = []
        self.encode_ms: list[float] = []
        self._period_ns = round(NS_PER_S / config.fps)
        self._pictures = pictures
        self._encoders = defaultdict[str, PictureEncoder](PictureEncoder)
        self._decoders = defaultdict[str, PictureDecoder](PictureDecoder)

    def picture(self, camera: str, seq: int, setting: StreamSetting) -> Encoded:
        """Encode a camera's picture of this number as it is sent; note the time, and of some their similarity."""
        images = self._pictures[camera]
        image, t_ns = images[seq % len(images)], seq * self._period_ns
        began = time.process_time()
        encoded = self._encoders[camera].encode(image, setting, seq, t_ns)
        self.encode_ms.append(1000.0 * (time.process_time() - began))
        decoded = self._decoders[camera].decode(live_frame(camera, seq, t_ns, encoded))
        if seq % COMPARED_EVERY == 0 and decoded is not None:
            size_px = image.shape[1], image.shape[0]
            self.ssims.append(ssim(np.asarray(cv2.resize(decoded, size_px), dtype=np.uint8), image))
        return encoded
