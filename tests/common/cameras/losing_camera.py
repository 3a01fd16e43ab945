"""A running camera that loses pictures."""

import numpy as np

from common.cameras.camera import Frame
from common.cameras.live import LiveCamera
from common.errors import CameraError

MOST, PER_FRAME, AT_LAST = 5, 2, 7


class LosingCamera(LiveCamera):
    """Loses PER_FRAME pictures before each that it gives, and after MOST of them all: AT_LAST, and it fails."""

    def __init__(self, name: str) -> None:
        self.name, self.lost, self._given = name, 0, 0

    def read(self) -> Frame:
        if self._given == MOST:
            self.lost += AT_LAST
            raise CameraError(f"camera {self.name} delivers no more frames")
        self.lost += PER_FRAME
        self._given += 1
        return Frame(np.zeros((3, 4), np.uint8), self._given, self._given)

    def close(self) -> None: ...


LOST = MOST * PER_FRAME + AT_LAST
