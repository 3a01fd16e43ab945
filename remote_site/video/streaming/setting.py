"""How a camera's pictures are sent: quality, size and rate, and the best of them within a byte rate."""

from dataclasses import dataclass

import numpy as np

# Sizes of JPEG pictures relative to those of quality 80, a mean of rendered views with and without a camera's noise.
# What a camera really gives is measured; the table only extrapolates from there.
QUALITIES = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0)
SIZES = (0.38, 0.45, 0.51, 0.56, 0.61, 0.67, 0.77, 1.0, 1.6, 4.0)
SCALE_EXPONENT = 1.6  # half the width and height takes a third of the bytes
RUNGS = ((1.0, 1.0), (0.75, 1.0), (0.5, 1.0), (0.5, 0.5), (0.5, 1 / 3))  # size and rate, best first
LEAST_QUALITY = 40
LAST_QUALITY = 20
LEAST_FPS = 2.0
ROOM_TO_RISE = 1.15  # so that a camera at the border of two rungs does not go up and down


@dataclass(frozen=True, slots=True)
class StreamSetting:
    """JPEG quality (1 to 100), size as a fraction of the camera's own width and height, pictures a second."""

    quality: int
    scale: float
    fps: float

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


def _allowed(bytes_per_s: float, reference_bytes: float, scale: float, fps: float) -> float:
    """How large a picture may be at this size and rate, relative to one of quality 80."""
    return bytes_per_s / (fps * reference_bytes * _area(scale))


def _area(scale: float) -> float:
    return float(scale**SCALE_EXPONENT)


def _size(quality: float) -> float:
    return float(np.interp(quality, QUALITIES, SIZES))


def _quality(allowed: float, most: int) -> int:
    return max(1, min(most, int(np.interp(allowed, SIZES, QUALITIES))))
