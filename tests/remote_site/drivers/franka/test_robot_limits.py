"""The FR3's limits: what a step would break is said, and the ready configuration never comes near them."""

import numpy as np
import pytest

from remote_site.drivers.franka.robot_limits import FR3, StepCheck, too_much
from tests.remote_site.drivers.franka.fake_robot import CONFIG, SETUP

Q = np.array([0.0, 0.0, 0.0, -1.5, 0.0, 1.5, 0.0])
FIRST = np.array([1.0, *np.zeros(6)])


def test_a_step_within_all_limits_breaks_none() -> None:
    check = StepCheck(FR3, Q)
    assert check.broken(Q, 1) == ""
    assert check.broken(Q + 4e-6 * FIRST, 1) == ""


@pytest.mark.parametrize(
    ("steps", "broken"),
    [
        ([6e-6], "the jerk of joint 1 would be 6000, and the robot allows -5000 to 5000 rad/s³"),
        ([4.9e-6, 14.6e-6, 24.5e-6], ""),
        ([4e-6, 12e-6, 23e-6], "the acceleration of joint 1 would be"),
    ],
)
def test_what_a_step_breaks_is_named(steps: list[float], broken: str) -> None:
    check, q = StepCheck(FR3, Q), Q
    said = ""
    for step in steps:
        q = q + step * FIRST
        said = said or check.broken(q, 1)
        check.note_sent(q, 1)
    assert (broken in said) if broken else said == ""


def test_a_joint_may_be_slower_near_its_end() -> None:
    near = FR3.upper - 0.05
    assert (FR3.fastest(near) < FR3.velocity).all()
    assert (FR3.fastest(FR3.upper) == 0.0).all()
    assert (FR3.slowest(FR3.lower) == 0.0).all()
    assert np.allclose(FR3.fastest(Q)[:4], 2.62)
    assert FR3.fastest(np.array([2.7, *Q[1:]]))[0] == pytest.approx(np.sqrt(12 * (2.9007 - 2.7)) - 0.652)


def test_beyond_the_end_is_a_position() -> None:
    end = np.array([2.9007, *Q[1:]])
    assert StepCheck(FR3, end).broken(end + 0.01 * FIRST, 1).startswith("the position of joint 1")


def test_lost_milliseconds_count_as_their_time() -> None:
    check = StepCheck(FR3, Q)
    check.note_sent(Q, 1)
    assert check.broken(Q + 4.9e-6 * FIRST, 1) == ""
    assert check.broken(Q + 2.5e-5 * FIRST, 1) != ""
    assert check.broken(Q + 2.5e-5 * FIRST, 3) == ""


def test_the_ready_configuration_leaves_room_and_brakes_before_the_robot_demands_it() -> None:
    assert too_much(SETUP.joint_names, SETUP.limits, FR3) == []
    own = SETUP.own_range
    assert own is not None
    assert np.allclose((own.lower, own.upper, own.velocity), (FR3.lower, FR3.upper, FR3.velocity))
    limits = SETUP.limits
    for share in np.linspace(0.0, 1.0, 101):
        speed = share * limits.velocity
        ahead = speed**2 / (2 * limits.acceleration)  # the least in which a joint comes to rest at its own limit
        assert (speed <= FR3.fastest(limits.upper - ahead) + 1e-9).all()
        assert (-speed >= FR3.slowest(limits.lower + ahead) - 1e-9).all()
    assert CONFIG.driver.name == "franka"
