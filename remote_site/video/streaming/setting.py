"""Setting of a camera's stream: codec, quality, size and rate, and the best of them within a byte rate."""

from dataclasses import dataclass, replace

import numpy as np

from common.messages.video import Codec

# Sizes of JPEG pictures relative to those of quality 80, a mean of rendered views with and without a camera's noise.
# What a camera really gives is measured; the table only extrapolates from there.
QUALITIES = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0)
SIZES = (0.38, 0.45, 0.51, 0.56, 0.61, 0.67, 0.77, 1.0, 1.6, 4.0)
SCALE_EXPONENT = 1.6  # half the width and height takes a third of the bytes
RUNGS = ((1.0, 1.0), (0.75, 1.0), (0.5, 1.0), (0.5, 0.5), (0.5, 1 / 3))  # size and rate, best first
LEAST_QUALITY = 40
LAST_QUALITY = 20
LEAST_FPS = 2.0
LEAST_BITS, MOST_BITS = 0.03, 0.4  # of H.264 for each pixel of each picture, on average
MUCH_LESS, MUCH_MORE = 0.9, 1.3  # than the H.264 encoder in force was opened for
ROOM_TO_RISE = 1.15  # so that a camera at the border of two rungs does not go up and down


@dataclass(frozen=True, slots=True)
class StreamSetting:
    """JPEG quality (1 to 100), size as a fraction of the camera's own width and height, pictures a second.

    With H.264 `quality` has no effect, and `picture_bytes` is what a picture may take on average, None as much as is of
    use.
    """

    quality: int
    scale: float
    fps: float
    codec: Codec = Codec.JPEG
    picture_bytes: int | None = None

    @property
    def relative_bytes(self) -> float:
        """A picture's bytes relative to one of quality 80 at full size, roughly."""
        return _size(self.quality) * _area(self.scale)


def fit(bytes_per_s: float, reference_bytes: float, full: StreamSetting, now: StreamSetting) -> StreamSetting:
    """The best setting that takes no more than `bytes_per_s`, at most `full`; the last resort is a slow rate.

    `reference_bytes` is what a picture of quality 80 at full size would take, `now` the setting in force.
    """
    for scale, rate in RUNGS[:-1]:
        fps = full.fps * rate
        allowed = _allowed(bytes_per_s, reference_bytes, scale, fps)
        room = ROOM_TO_RISE if (scale, fps) > (now.scale, now.fps) else 1.0
        if allowed >= room * _size(LEAST_QUALITY):
            return StreamSetting(_quality(allowed, full.quality), scale, fps)
    scale, rate = RUNGS[-1]
    fps = full.fps * rate
    allowed = _allowed(bytes_per_s, reference_bytes, scale, fps)
    if allowed >= _size(LAST_QUALITY):
        return StreamSetting(_quality(allowed, min(full.quality, LEAST_QUALITY)), scale, fps)
    return StreamSetting(LAST_QUALITY, scale, max(LEAST_FPS, fps * allowed / _size(LAST_QUALITY)))


def fit_h264(bytes_per_s: float, pixels: int, full: StreamSetting, now: StreamSetting) -> StreamSetting:
    """The best H.264 that takes no more than `bytes_per_s`, at most `full`; the last resort is a slow rate.

    `pixels` are those of a full picture. A new `picture_bytes` costs a new encoder and a key frame: it stays that of
    `now` while the difference is small.
    """
    setting = StreamSetting(full.quality, RUNGS[-1][0], max(LEAST_FPS, full.fps * RUNGS[-1][1]), Codec.H264)
    for scale, rate in RUNGS:
        fps = full.fps * rate
        better = now.codec is Codec.H264 and scale > now.scale
        if bytes_per_s >= (ROOM_TO_RISE if better else 1.0) * fps * _bytes_of(LEAST_BITS, pixels, scale):
            setting = replace(setting, scale=scale, fps=fps)
            break
    else:
        least = _bytes_of(LEAST_BITS, pixels, setting.scale)
        setting = replace(setting, fps=max(LEAST_FPS, min(setting.fps, bytes_per_s / least)))
    least, most = (_bytes_of(bits, pixels, setting.scale) for bits in (LEAST_BITS, MOST_BITS))
    target = max(least, bytes_per_s / setting.fps)
    if target >= most:
        return setting
    in_force = most if now.picture_bytes is None else now.picture_bytes
    same = now.codec is Codec.H264 and now.scale == setting.scale
    kept = same and in_force * MUCH_LESS < target < in_force * MUCH_MORE
    return replace(setting, picture_bytes=now.picture_bytes if kept else round(target))


def most_h264_bytes(pixels: int) -> int:
    """Compute what a picture of this size takes in H.264 on average, at most: more would not be seen."""
    return round(_bytes_of(MOST_BITS, pixels, 1.0))


def _bytes_of(bits_per_pixel: float, pixels: int, scale: float) -> float:
    return bits_per_pixel * pixels * scale**2 / 8


def _allowed(bytes_per_s: float, reference_bytes: float, scale: float, fps: float) -> float:
    """Compute how large a picture may be at this size and rate, relative to one of quality 80."""
    return bytes_per_s / (fps * reference_bytes * _area(scale))


def _area(scale: float) -> float:
    return float(scale**SCALE_EXPONENT)


def _size(quality: float) -> float:
    return float(np.interp(quality, QUALITIES, SIZES))


def _quality(allowed: float, most: int) -> int:
    return max(1, min(most, int(np.interp(allowed, SIZES, QUALITIES))))
