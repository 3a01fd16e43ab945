"""The operator's pictures of the cell: rate, age and likeness of those that reached the page."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from common.cameras.camera import Image
from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.video import Codec, VideoFrame
from farhand.loopback.picture_decoder import PictureDecoder
from lab.stage.stand_ins.pictures import SeenPictures, read_pictures, read_sights
from lab.stage.stand_ins.played_remote import number_of
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import encode_jpeg

COMPARED = 4  # pictures of each camera
Figures = dict[str, Any]
WINDOW, SIGMA = (11, 11), 1.5
C1, C2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2


def ssim(one: Image, other: Image) -> float:
    """The mean SSIM of the brightness of two BGR pictures of one size, 1 where they are the same.

    Wang, Bovik, Sheikh, Simoncelli: Image quality assessment, IEEE Trans. Image Processing 13 (2004), with the
    authors' Gaussian window of 11 x 11 and their constants.
    """
    x, y = (cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float64) for image in (one, other))
    mean_x, mean_y = _smooth(x), _smooth(y)
    var_x, var_y = _smooth(x * x) - mean_x**2, _smooth(y * y) - mean_y**2
    covariance = _smooth(x * y) - mean_x * mean_y
    likeness = (2 * mean_x * mean_y + C1) * (2 * covariance + C2)
    return float(np.mean(likeness / ((mean_x**2 + mean_y**2 + C1) * (var_x + var_y + C2))))


def _smooth(values: Array) -> Array:
    return np.asarray(cv2.GaussianBlur(values, WINDOW, SIGMA))


@dataclass(frozen=True, slots=True)
class Seen:
    """A picture on the page: the message, and how it came."""

    frame: VideoFrame
    sight: SeenPictures

    @property
    def age_ms(self) -> float:
        """Its true age when the page had it: all processes share one clock."""
        return (self.sight.seen_ns - self.frame.capture_ns) / NS_PER_MS


def read_seen(pictures: Path, sights: Path) -> list[Seen]:
    """The pictures that reached the page, in that order."""
    frames = {(frame.camera, frame.seq): frame for _, frame in read_pictures(pictures)}
    seen = ((frames.get((sight.camera, sight.seq)), sight) for sight in read_sights(sights))
    return [Seen(frame, sight) for frame, sight in seen if frame is not None]


def picture_figures(seen: Sequence[Seen], cameras: Sequence[str], from_ns: int, to_ns: int) -> Figures:
    """Within a time: the least rate of a camera, ages of all (p50, p95, ms), the rate of all (Mbit/s), their size.

    `h264` is the fraction of the pictures that came as H.264.
    """
    within = [one for one in seen if from_ns <= one.sight.seen_ns < to_ns]
    seconds = (to_ns - from_ns) / NS_PER_S
    counts = [sum(one.frame.camera == name for one in within) for name in cameras]
    ages = [one.age_ms for one in within]
    return {
        "fps": min(counts) / seconds,
        **{f"age_p{p}_ms": float(np.percentile(ages, p)) if ages else None for p in (50, 95)},
        "video_mbit_s": 8e-6 * sum(len(one.frame.data) for one in within) / seconds,
        "h264": float(np.mean([one.frame.codec is Codec.H264 for one in within])) if within else None,
        "width_px": float(np.median([one.frame.width for one in within])) if within else None,
    }


def understated_ms(seen: Sequence[Seen]) -> float | None:
    """By how much a picture was older, at most, than the page had to believe: None where no age was known."""
    known = [one.age_ms - one.sight.oldest_ms for one in seen if one.sight.oldest_ms is not None]
    return max(known, default=None)


class Likeness:
    """Compares pictures with those that the cameras played; remembers what JPEG of quality 80 makes of them."""

    def __init__(self, source: Path) -> None:
        self._source = source
        self._quality = VideoConfig().quality
        self._as_jpeg: dict[tuple[str, int], float] = {}

    def figures(self, seen: Sequence[Seen], cameras: Sequence[str], from_ns: int, to_ns: int) -> Figures:
        """The mean SSIM of a few pictures of each camera, and how much less that is than by JPEG at full quality."""
        found, as_jpeg = [], []
        for camera in cameras:
            images = np.load(self._source / f"{camera}.npy", mmap_mode="r")
            within = [one for one in seen if one.frame.camera == camera and from_ns <= one.sight.seen_ns < to_ns]
            wanted = {one.frame.seq for one in within[:: max(1, len(within) // COMPARED)]}
            for frame, image in decoded([one.frame for one in seen if one.frame.camera == camera], wanted):
                number = number_of(frame.capture_ns, len(images))
                found.append(ssim(np.array(images[number]), fitted(image, images.shape[2], images.shape[1])))
                as_jpeg.append(self._by_jpeg(camera, number, images))
        if not found:
            return {"ssim": None, "ssim_below_jpeg": None}
        return {"ssim": float(np.mean(found)), "ssim_below_jpeg": float(np.mean(as_jpeg) - np.mean(found))}

    def _by_jpeg(self, camera: str, number: int, images: Image) -> float:
        if (camera, number) not in self._as_jpeg:
            image = np.array(images[number])
            self._as_jpeg[camera, number] = ssim(image, decode_jpeg(encode_jpeg(image, self._quality)))
        return self._as_jpeg[camera, number]


def decoded(frames: Sequence[VideoFrame], wanted: set[int]) -> Iterator[tuple[VideoFrame, Image]]:
    """The pictures of one camera with these numbers, decoded as the page would from all that reached it."""
    decoder = PictureDecoder()
    for frame in frames:
        if frame.codec is not Codec.JPEG or frame.seq in wanted:
            image = decoder.decode(frame)
            if image is not None and frame.seq in wanted:
                yield frame, image


def decode_jpeg(data: bytes) -> Image:
    """A JPEG as (H, W, 3) BGR."""
    return np.asarray(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR), dtype=np.uint8)


def fitted(image: Image, width: int, height: int) -> Image:
    """The picture in the size of its source, as the page shows a smaller one."""
    if image.shape[:2] == (height, width):
        return image
    return np.asarray(cv2.resize(image, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.uint8)
