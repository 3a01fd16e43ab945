"""The search: two views that find a hand in one place give a start; a place or a size that does not fit gives none."""

import numpy as np
import pytest
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import image_of, project
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.eye.arm_points import MIDDLE_KNUCKLE, WRIST
from local_site.tracking.eye.hand_search import HandSearch
from local_site.tracking.eye.networks import EyeNetworks

WIDTH, HEIGHT = 640, 480
ALONG = np.array([0.0, 0.6, 0.8])


class _Told(EyeNetworks):
    """Finds what it is told, for each picture in turn."""

    def __init__(self, answers: list[NDArray[np.float32]]) -> None:
        self._answers = iter(answers)

    def find(self, picture: Image) -> NDArray[np.float32]:
        assert picture.shape == (144, 192, 3)
        return next(self._answers)


@pytest.fixture
def rig() -> Rig:
    return exact_rig(StereoConfig())


def answer(rig: Rig, k: int, middle: Array, *, larger: float = 1.0, off_px: float = 0.0) -> NDArray[np.float32]:
    """The finder's answer for a hand in one of the rig's views."""
    camera = rig.cameras[k]
    at = camera.distort_pixels(project(camera.matrix, np.array([middle, middle + 0.05 * ALONG])))
    unit_px = 0.1 * float(np.linalg.norm(image_of(camera.matrix, middle)[1], 2))
    x, y = (at[0] + [0.0, off_px]) * 192 / WIDTH / 4
    column, row = int(x), int(y)
    cells = np.zeros((7, 36, 48), np.float32)
    cells[0] = -6.0
    cells[0, row, column] = 4.0
    way = at[1] - at[0]
    told = [x - column - 0.5, y - row - 0.5, *(way / np.linalg.norm(way)), np.log(larger * unit_px / WIDTH)]
    cells[2:, row, column] = told
    return cells


def starts(rig: Rig, answers: list[NDArray[np.float32]]) -> list[Array]:
    pictures = [np.zeros((HEIGHT, WIDTH, 3), np.uint8)] * len(rig.cameras)
    return HandSearch(rig, _Told(answers)).starts(pictures)


def test_a_hand_that_two_views_find_gives_a_start_where_it_is(rig: Rig) -> None:
    middle = (np.array(rig.volume_min) + np.array(rig.volume_max)) / 2
    (points,) = starts(rig, [answer(rig, k, middle) for k in range(2)])
    found = 0.5 * (points[WRIST] + points[MIDDLE_KNUCKLE])
    assert np.linalg.norm(found - middle) < 0.003
    along = points[MIDDLE_KNUCKLE] - points[WRIST]
    assert along @ ALONG / np.linalg.norm(along) > 0.97


@pytest.mark.parametrize("wrong", [{"larger": 2.2}, {"off_px": 60.0}])
def test_views_that_do_not_find_the_same_hand_give_none(rig: Rig, wrong: dict[str, float]) -> None:
    middle = (np.array(rig.volume_min) + np.array(rig.volume_max)) / 2
    assert starts(rig, [answer(rig, 0, middle), answer(rig, 1, middle, **wrong)]) == []
