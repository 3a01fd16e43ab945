"""The camera interface: a source of frames, each stamped once with its capture time."""

from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

Image = NDArray[np.uint8]
Source = Annotated[int, Meta(ge=0)] | Annotated[str, Meta(min_length=1)]  # device, URL, video file, folder of images


@dataclass(frozen=True, slots=True)
class Frame:
    """One exposure.

    `image` is (H, W) grey or (H, W, 3) BGR, uint8; `capture_ns` the capture time on this host's monotonic clock
    (in a recording, from its start); `seq` counts this camera's frames from 0. With `capture_estimated` the capture
    time is the arrival minus a configured latency, as the camera's driver gives no time stamp on this clock.
    """

    image: Image
    capture_ns: int
    seq: int
    capture_estimated: bool = False


class Camera(Protocol):
    """A source of frames; the constructor opens it, or raises CameraError with the remedy."""

    @property
    def name(self) -> str: ...

    def read(self) -> Frame | None:
        """Wait for the next frame; None at the end of a recording; CameraError when a live source fails."""

    def close(self) -> None: ...
