"""An arm that late samples have stopped is led back to the hand: at most 50 mm/s beyond what the hand does."""

from functools import cache

import numpy as np
import pytest

from common.messages.robot import SessionState
from tests.remote_site.remote_loop import TICK_NS, Point, assert_within_limits
from tests.remote_site.teleop.far_link import FarLink, Motion, Run, circle, engaged_over

CUT_S, SECONDS = 6.0, 4.6  # from the first sample, and of following
TICK_S = TICK_NS / 1e9
BEYOND_MM_S = 50.0
TRACKING_MM_S = 3.0  # of the joints that track the target, while they catch up with its acceleration
STEADY_FROM_S = 5.4


def steadily(speed_m_s: float) -> Motion:
    """A hand that rests at first, and then goes straight on at this speed."""

    def motion(t_s: float) -> Point:
        moving_s = max(t_s - STEADY_FROM_S, 0.0)
        way = speed_m_s * (moving_s**2 / 0.6 if moving_s < 0.3 else moving_s - 0.15)
        return way - 0.1, 0.0, 0.3

    return motion


def slow_circle(t_s: float) -> Point:
    """A circle at 75 mm/s in the horizontal plane."""
    x, _, up = circle(t_s)
    return x, up - 0.34, 0.3


def speeds_mm_s(run: Run) -> np.ndarray:
    """The tool's speed in every tick since the link changed."""
    since = round((CUT_S - run.begun_ns / 1e9) / TICK_S)
    speeds: np.ndarray = 1e3 * np.linalg.norm(np.diff(np.array(run.tools[since:]), axis=0), axis=1) / TICK_S
    return speeds


@cache
def after(link: FarLink, speed_mm_s: int) -> Run:
    """A hand at a steady speed over a link that changes."""
    return engaged_over(link, SECONDS, steadily(speed_mm_s / 1e3))


def cut(seconds: float) -> FarLink:
    """20 ms each way, cut for this time."""
    return FarLink(20, cuts=((CUT_S, CUT_S + seconds),))


@pytest.mark.slow
@pytest.mark.parametrize("link", [cut(0.1), cut(0.2), cut(0.3), FarLink(20, longer=(CUT_S, 120.0))], ids=str)
@pytest.mark.parametrize("speed_mm_s", [20, 100])
def test_after_a_hold_the_tool_goes_at_most_50_mm_a_second_faster_than_the_hand(link: FarLink, speed_mm_s: int) -> None:
    run = after(link, speed_mm_s)
    assert run.holds == 1
    assert run.states[-1] is SessionState.ENGAGED
    assert speeds_mm_s(run).max() <= speed_mm_s + BEYOND_MM_S + TRACKING_MM_S
    assert_within_limits(run.loop)


@pytest.mark.slow
def test_it_has_caught_up_within_two_seconds() -> None:
    run = engaged_over(cut(0.2), 7.0, slow_circle)
    undisturbed = engaged_over(FarLink(20), 7.0, slow_circle)
    off = np.linalg.norm(np.array(run.tools) - np.array(undisturbed.tools), axis=1)
    caught_up = round((CUT_S + 2.0 - run.begun_ns / 1e9) / TICK_S)
    assert off.max() > 0.005
    assert off[caught_up:].max() < 0.001
    assert speeds_mm_s(run).max() <= 76 + BEYOND_MM_S
