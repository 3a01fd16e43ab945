"""Counts of the pictures that live cameras have lost: kept by the process that reads them, read by others."""

import mmap
from collections.abc import Callable, Sequence

import numpy as np

from common.cameras.camera import Camera
from common.cameras.live import LiveCamera

COUNT_BYTES = 8


class LostPictures:
    """One count for each of `cameras`, also over several openings. Create it before the fork."""

    def __init__(self, cameras: Sequence[str]) -> None:
        self.cameras = tuple(cameras)
        memory = mmap.mmap(-1, max(1, len(self.cameras)) * COUNT_BYTES)  # nothing can be mapped of no size
        self._counts = np.frombuffer(memory, dtype=np.int64)[: len(self.cameras)]

    def read(self) -> dict[str, int]:
        """The count of each camera so far."""
        return dict(zip(self.cameras, self._counts.tolist(), strict=True))

    def follow(self, name: str, camera: Camera) -> Callable[[], None]:
        """Return a function to call after each reading of the camera of this name; it counts the losses since."""
        row = self._counts[self.cameras.index(name) :]
        noted = 0

        def note() -> None:
            nonlocal noted
            if isinstance(camera, LiveCamera):
                row[0] += camera.lost - noted
                noted = camera.lost

        return note
