"""Two fake cameras before a printed board that is held still at one place after another."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from common.cameras.camera import Frame, Image
from common.cameras.settings import CameraSettings
from common.errors import CameraError
from common.geometry import Array
from farhand.setup.board_page import BOARD
from local_site.simulation.calibration_scenes.board_scene import BoardRenderer
from tests.local_site.calibration.board_scenes import looking_down

SIDES = {"fake://a": -1, "fake://b": 1}
HELD_FRAMES = 7
FLAT = np.diag([1.0, -1.0, -1.0])


def placed(count: int) -> Iterator[tuple[Array, Array]]:
    """Poses (operator_R_board, translation): flat at the origin, then spread over both pictures and tilted."""
    random = np.random.default_rng(5)
    yield FLAT, -FLAT @ BOARD.middle
    for _ in range(count - 1):
        tilt = Rotation.from_euler("xyz", random.uniform((-5, -35, -25), (70, 35, 25)), degrees=True).as_matrix()
        middle = random.uniform((-0.2, -0.2, -0.05), (0.2, 0.2, 0.25))
        yield tilt @ FLAT, middle - tilt @ FLAT @ BOARD.middle


@lru_cache(maxsize=4)
def pictures(source: str, count: int) -> Sequence[Image]:
    """What a camera sees of the poses."""
    renderer = BoardRenderer(BOARD, looking_down(SIDES[source]), seed=SIDES[source] + 1)
    return [renderer.picture(*pose) for pose in placed(count)]


class BoardCamera:
    """Shows each pose for some frames; `broken` sources are refused, with the cure."""

    def __init__(self, source: str, name: str, settings: CameraSettings, count: int = 30) -> None:
        if source not in SIDES:
            raise CameraError(f"camera {name}: cannot open {source}; is it plugged in, and may this user read it?")
        self.name = name
        self.settings = settings
        self.closed = False
        self._pictures = pictures(source, count)
        self._seq = 0

    def read(self) -> Frame | None:
        if self._seq >= HELD_FRAMES * len(self._pictures):
            return None
        image = self._pictures[self._seq // HELD_FRAMES]
        frame = Frame(image, self._seq * 33_000_000, self._seq)
        self._seq += 1
        return frame

    def close(self) -> None:
        self.closed = True
