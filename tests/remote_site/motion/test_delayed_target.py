"""The pace of a target on the hand's path: what all joints can follow, braked in time, and caught up gently."""

from itertools import pairwise

import numpy as np
import pytest

from common.geometry import Array
from remote_site.kinematics.limits import JointLimits
from remote_site.motion.catch_up import CATCH_UP_M_S
from remote_site.motion.delayed_target import BEGIN_M, CATCH_UP, FAR_M, LONGEST_S, DelayedTarget, Followed
from tests.remote_site.motion.test_stretched_elbow import CONFIG
from tests.remote_site.remote_loop import arm

DT = 0.004
LIMITS: JointLimits = arm(CONFIG)[1]
ON_ITS_WAY = np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.0])
EASY = 0.1 * LIMITS.velocity


def follows(asked: Array, off_m: float = 0.0, dq: Array = EASY) -> Followed:
    return Followed(dq, asked, np.array([off_m, 0.0, 0.0]))


def advanced(target: DelayedTarget, arm: Followed, ticks: int, **options: bool) -> list[float]:
    """The paces of so many ticks."""
    paces = []
    for _ in range(ticks):
        target.advance(arm, 1.0, ON_ITS_WAY, barred=options.get("barred", False))
        paces.append(target.pace)
    return paces


@pytest.fixture
def target() -> DelayedTarget:
    return DelayedTarget(LIMITS, DT)


@pytest.fixture
def late(target: DelayedTarget) -> DelayedTarget:
    advanced(target, follows(2.0 * LIMITS.velocity), 250)
    assert target.delay_s > 0.3
    return target


def test_a_target_that_can_be_followed_keeps_the_hands_pace(target: DelayedTarget) -> None:
    assert set(advanced(target, follows(EASY, off_m=0.9 * BEGIN_M), 500)) == {1.0}
    assert target.delay_s == 0.0


def test_one_that_asks_for_twice_the_joints_speeds_goes_half_as_fast_and_brakes_to_it(target: DelayedTarget) -> None:
    paces, asked = [1.0], 2.0 * LIMITS.velocity
    for _ in range(250):
        dq = np.minimum(paces[-1] * asked, LIMITS.velocity)
        paces += advanced(target, follows(asked, dq=dq), 1)
    assert paces[-1] == pytest.approx(0.45, abs=0.06)
    braked = [before - after for before, after in pairwise(paces) if before <= 0.5]
    assert 0.0 < max(braked) <= 0.73 * DT * float(np.min(LIMITS.acceleration / asked))


def test_joints_that_are_not_on_their_way_yet_need_not_be_braked(target: DelayedTarget) -> None:
    assert advanced(target, follows(2.0 * LIMITS.velocity, dq=0.2 * LIMITS.velocity), 1)[0] < 0.5


def test_the_delay_is_what_the_pace_leaves(target: DelayedTarget) -> None:
    paces = advanced(target, follows(2.0 * LIMITS.velocity), 250)
    assert target.delay_s == pytest.approx(DT * sum(1.0 - pace for pace in paces))


def test_a_slowed_arm_has_less_speed_to_follow_with(target: DelayedTarget) -> None:
    for _ in range(500):
        target.advance(follows(0.5 * LIMITS.velocity), 0.25, ON_ITS_WAY, barred=False)
    assert target.pace < 0.55


def test_it_is_slower_where_what_is_asked_of_the_joints_grows_quickly(late: DelayedTarget) -> None:
    paces = []
    for k in range(60):
        growing = follows((0.2 + 0.02 * k) * LIMITS.velocity)
        late.advance(growing, 1.0, ON_ITS_WAY, barred=False)
        paces.append(late.pace)
    straight = advanced(late, follows(0.2 * LIMITS.velocity), 60)
    assert paces[-1] < 0.8 * straight[-1]


def test_it_waits_for_a_tool_that_is_off_its_path(late: DelayedTarget) -> None:
    paces = []
    for k in range(250):
        paces += advanced(late, follows(EASY, off_m=(3.0 - k / 250) * FAR_M), 1)
    assert paces[-1] == 0.0
    assert max(advanced(late, follows(EASY), 500)) > 1.0


def test_what_is_left_is_caught_up_no_faster_than_allowed_beyond_the_hand(late: DelayedTarget) -> None:
    paces = advanced(late, follows(EASY), 200)
    assert max(paces) * 0.1 <= 0.1 + CATCH_UP * CATCH_UP_M_S + 1e-9
    assert advanced(late, follows(EASY), 500)[-1] == 1.0
    assert late.delay_s == 0.0


def test_an_arm_that_comes_no_nearer_is_not_waited_for_until_it_is_near_again(late: DelayedTarget) -> None:
    advanced(late, follows(EASY, off_m=0.1), 160)
    assert (late.delay_s, late.pace) == (0.0, 1.0)
    advanced(late, follows(EASY, off_m=0.09), 100)
    assert late.delay_s == 0.0
    advanced(late, follows(EASY), 1)
    advanced(late, follows(2.0 * LIMITS.velocity), 50)
    assert late.delay_s > 0.0


def test_an_obstacle_a_reset_or_too_long_a_path_ends_it(late: DelayedTarget) -> None:
    longest = 0.0
    for k in range(round((LONGEST_S + 1.0) / DT)):
        advanced(late, follows(EASY, off_m=1.0 - k / 2000), 1)
        longest = max(longest, late.delay_s)
    assert LONGEST_S - 0.1 < longest <= LONGEST_S
    assert late.delay_s < LONGEST_S - 0.1
    advanced(late, follows(2.0 * LIMITS.velocity), 100)
    advanced(late, follows(2.0 * LIMITS.velocity), 1, barred=True)
    assert (late.delay_s, late.pace) == (0.0, 1.0)
    advanced(late, follows(2.0 * LIMITS.velocity), 100)
    late.reset()
    assert (late.delay_s, late.pace) == (0.0, 1.0)
