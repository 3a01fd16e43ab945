"""How much slower the arm moves into a singular posture: by its condition number, and not on the way out."""

import numpy as np
import pytest

from remote_site.kinematics.config import SingularityConfig
from remote_site.kinematics.dexterity import FULL, Dexterity
from remote_site.reasons import Code
from tests.remote_site.remote_loop import arm

MODEL, _ = arm()
CONFIG = SingularityConfig()
DEXTERITY = Dexterity(MODEL, CONFIG)


def bent(wrist: float) -> np.ndarray:
    """A posture with joint 5, whose zero is singular, at an angle in rad."""
    return np.array([0.0, 0.0, -0.8, 0.0, wrist, 0.0])


@pytest.mark.parametrize("radius_m", [0.1, 0.3, 1.0])
def test_the_condition_is_that_of_metres_and_of_turns_of_the_given_radius(radius_m: float) -> None:
    jacobian = np.array(MODEL.jacobian(bent(-0.7)))
    jacobian[3:] *= radius_m
    found = Dexterity(MODEL, SingularityConfig(radius_m=radius_m)).condition(bent(-0.7))
    assert found == pytest.approx(np.linalg.cond(jacobian), rel=1e-9)


@pytest.mark.parametrize(("wrist", "left"), [(-0.08, 0.82), (-0.05, 0.52), (-0.03, 0.31), (-0.02, 0.3), (0.0, 0.3)])
def test_into_a_singular_posture_speed_falls_as_the_condition_rises_down_to_the_slowest(
    wrist: float, left: float
) -> None:
    slowing = DEXTERITY.slowing(bent(wrist), bent(wrist / 2))
    assert slowing.fraction == pytest.approx(
        max(CONFIG.slow_condition / DEXTERITY.condition(bent(wrist)), CONFIG.slowest)
    )
    assert slowing.fraction == pytest.approx(left, abs=0.01)
    assert slowing.reason is not None
    assert slowing.reason.code is Code.SINGULAR
    assert DEXTERITY.slowing(bent(wrist), bent(wrist)) == slowing  # an arm that stays is not on its way out


def test_out_of_it_and_far_from_it_nothing_slows() -> None:
    assert DEXTERITY.slowing(bent(-0.03), bent(-0.1)) is FULL
    assert DEXTERITY.slowing(bent(0.0), bent(-0.1)) is FULL
    assert DEXTERITY.slowing(bent(-0.7), bent(-0.3)) is FULL
    begins_here = SingularityConfig(slow_condition=DEXTERITY.condition(bent(-0.05)))
    assert Dexterity(MODEL, begins_here).slowing(bent(-0.05), bent(0.0)) is FULL
