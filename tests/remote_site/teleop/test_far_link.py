"""An arm far away: on every ordinary link it follows, hardly ever holds, and errs hardly more than on a perfect one."""

from functools import cache

import numpy as np
import pytest

from common.messages.robot import SessionState
from remote_site.config import RemoteConfig
from remote_site.safety.config import SafetyConfig
from tests.remote_site.remote_loop import Point, assert_within_limits
from tests.remote_site.teleop.far_link import FarLink, Run, circle, engaged_over

SECONDS = 20.0
CAUGHT_UP_S = 1.0
NOTHING_MM = 0.2  # far below what a tracker measures: so small an increase of a small error is none
OVERSHOOT = 1.02  # of a speed below the joints' own, towards a target that changes its own
LAGS_S = [k / 200 for k in range(-8, 48)]


def least_error_mm(run: Run) -> float:
    """The error apart from the hand's lag, once the arm has caught up with a hand that moved when it was engaged."""
    return min(run.error_mm(circle, lag_s, CAUGHT_UP_S) for lag_s in LAGS_S)


@cache
def perfect(delay_ms: float) -> float:
    """The error over a link that only delays."""
    return least_error_mm(engaged_over(FarLink(delay_ms), SECONDS))


@pytest.mark.parametrize(
    "delay_ms", [120, *(pytest.param(delay_ms, marks=pytest.mark.long) for delay_ms in (2, 20, 40, 80))]
)
def test_the_arm_follows_over_a_link_that_spreads_and_loses_samples(delay_ms: float) -> None:
    run = engaged_over(FarLink(delay_ms, jitter=0.2, loss=0.03), SECONDS)
    assert run.followed >= 0.99
    assert run.holds <= 1
    assert run.most_changes(1.0) <= 2
    assert least_error_mm(run) <= max(1.2 * perfect(delay_ms), perfect(delay_ms) + NOTHING_MM)
    assert max(run.limits_ms) <= 400
    assert_within_limits(run.loop)


@pytest.mark.long
def test_with_a_fixed_limit_of_100_ms_the_arm_hardly_follows_over_such_a_link() -> None:
    config = RemoteConfig(safety=SafetyConfig(t_soft_ms=100.0))
    run = engaged_over(FarLink(40, jitter=0.2), SECONDS, config=config)
    assert run.states.count(SessionState.ENGAGED) * 0.004 < SECONDS / 2


@pytest.mark.slow
def test_a_delay_that_jumps_from_20_to_120_ms_costs_one_hold_and_the_arm_follows_within_2_s() -> None:
    run = engaged_over(FarLink(20, longer=(8.0, 120.0)), SECONDS)
    assert run.holds == 1
    held_s = sum(state is SessionState.HOLDING for state in run.states) * 0.004
    assert held_s < 2.0
    assert run.states[-1] is SessionState.ENGAGED
    assert run.limits_ms[-1] > 200
    assert_within_limits(run.loop)


@pytest.mark.slow
def test_a_cut_of_300_ms_holds_the_arm_which_follows_within_1_s() -> None:
    run = engaged_over(FarLink(40, jitter=0.2, cuts=((10.0, 10.3),)), SECONDS)
    assert run.holds == 1
    resumed_s = run.changes_s[1] + run.begun_ns / 1e9
    assert 10.3 < resumed_s < 11.3


@pytest.mark.slow
def test_no_joint_is_ever_faster_than_the_age_limit_in_force_allows() -> None:
    def fast(t_s: float) -> Point:
        return circle(t_s, radius_m=0.09, hz=0.7)

    run = engaged_over(FarLink(5, longer=(6.0, 60.0)), 12.0, fast)
    log = run.loop.log[-len(run.limits_ms) :]
    pace = np.array([run.loop.limits.pace(motion.dq, motion.ddq) for motion in log])
    allowed = np.array([min(1.0, 100.0 / limit_ms) for limit_ms in run.limits_ms])
    grew = np.flatnonzero(np.diff(run.limits_ms) > 0)
    assert len(grew) > 0
    assert pace.max() > allowed.min()  # the slower link alone would have been too fast
    for k in grew:
        assert pace[k] <= allowed[k + 1] * 1.001
    followed = np.array([state is SessionState.ENGAGED for state in run.states])
    assert (pace[followed] <= allowed[followed] * OVERSHOOT).all()
