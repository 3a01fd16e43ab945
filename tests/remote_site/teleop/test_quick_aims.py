"""A hand that aims quickly and stops: the tool arrives without swinging far beyond, and does not swing afterwards."""

import numpy as np
import pytest

from common.geometry import Array
from remote_site.config import RemoteConfig
from tests.remote_site.arms_followed import OFFSET_WRIST, SEVEN_AXES, Followed, HandMotion, smooth

BEGIN_S, AFTER_S = 0.3, 1.2
START = RemoteConfig()


def aim(way_m: tuple[float, float, float], seconds: float) -> HandMotion:
    """A minimum-jerk movement of the hand, operator frame."""

    def motion(t: float) -> tuple[Array, Array]:
        return smooth((t - BEGIN_S) / seconds) * np.array(way_m), np.zeros(3)

    return motion


def beyond(config: RemoteConfig, way_m: tuple[float, float, float], seconds: float) -> tuple[float, float]:
    """How far the tool goes beyond the way's end, and how far it still is from it a second later, both of the way."""
    followed = Followed(config, aim(way_m, seconds), BEGIN_S + seconds + AFTER_S)
    moved, way = followed.tools[:, :3, 3] - followed.start[:3, 3], followed.hands[-1]
    length = float(np.linalg.norm(way))
    along = moved @ way / length
    return float(along.max()) / length - 1.0, float(np.linalg.norm(moved[-1] - way)) / length


@pytest.mark.slow
@pytest.mark.parametrize("way_m", [(0.1, 0, 0), (0.06, 0.08, 0), (0, 0.1, 0), (0, 0, -0.1), (-0.15, 0, 0)])
def test_an_aim_of_half_a_second_is_hardly_overshot(way_m: tuple[float, float, float]) -> None:
    """The tool used to go twice as far, and to swing for a second: its joints cannot brake as hard as a hand."""
    over, off = beyond(START, way_m, 0.5 if np.linalg.norm(way_m) < 0.14 else 0.6)
    assert over < 0.12
    assert off < 0.02


def test_an_aim_that_no_joint_can_follow_is_overshot_by_less_than_its_length() -> None:
    over, off = beyond(START, (0.1, 0, 0), 0.35)
    assert over < 0.7
    assert off < 0.02


@pytest.mark.parametrize("config", [OFFSET_WRIST, SEVEN_AXES], ids=["offset wrist", "seven axes"])
def test_other_arms_hardly_overshoot_either(config: RemoteConfig) -> None:
    over, off = beyond(config, (0.1, 0, 0), 0.5)
    assert over < 0.2
    assert off < 0.02


def test_an_aim_of_a_second_is_not_overshot_at_all() -> None:
    over, _ = beyond(START, (0.1, 0, 0), 1.2)
    assert over < 0.02
