"""The camera interface: a source of frames, each stamped once with its exposure time."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Frame:
    """One exposure.

    `image` is (H, W) grey or (H, W, 3) BGR, uint8; `capture_ns` the exposure time on this host's monotonic clock
    (for a recording: time from its start); `seq` counts the frames of this camera from 0. With `capture_estimated` the
    exposure time is the arrival minus a configured latency, as the driver gives no time stamp.
    """

    image: Image
    capture_ns: int
    seq: int
    capture_estimated: bool = False


class Camera(Protocol):
    """A source of frames; the constructor opens it or raises CameraError with the cure."""

    @property
    def name(self) -> str: ...

    def read(self) -> Frame | None:
        """Wait for the next frame; None at the end of a recording; CameraError when a live source fails."""

    def close(self) -> None: ...
