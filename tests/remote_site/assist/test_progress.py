"""A lead is given up where the tool falls behind its target, or comes no nearer to its goal."""

import math

import pytest

from common.clock import NS_PER_S
from remote_site.assist.assist import LeadProgress

NONE = (0.0, 0.0)


def gives_up_s(left, lag=lambda _t_s: NONE, seconds=5.0):
    """When it gives up, s, fifty times a second; None if it does not."""
    progress = LeadProgress(7 * NS_PER_S)
    for k in range(round(50 * seconds)):
        if progress.is_stuck(left(k / 50), lag(k / 50), 7 * NS_PER_S + k * NS_PER_S // 50):
            return k / 50
    return None


def nearer(t_s):
    return 0.06 - 0.01 * t_s, 0.0


def test_a_tool_that_comes_slowly_nearer_may():
    assert gives_up_s(lambda t_s: (0.05 - 0.002 * t_s, 0.0)) is None
    assert gives_up_s(lambda t_s: (0.05, math.radians(20.0 - t_s))) is None


def test_one_that_stays_is_given_up_after_a_second_and_a_half():
    assert gives_up_s(lambda t_s: (max(0.05 - 0.02 * t_s, 0.03), 0.0)) == pytest.approx(2.5, abs=0.1)


def test_one_that_is_there_stays_as_long_as_it_likes():
    assert gives_up_s(lambda _t_s: (0.0005, 0.0), seconds=20.0) is None


def test_one_that_falls_behind_is_given_up_but_not_while_it_begins():
    assert gives_up_s(nearer, lambda _t_s: (0.03, 0.0)) == pytest.approx(0.62, abs=0.03)
    assert gives_up_s(nearer, lambda t_s: (0.0, 0.2 if t_s > 2 else 0.0)) == pytest.approx(2.02, abs=0.03)
    assert gives_up_s(nearer, lambda _t_s: (0.01, 0.1)) is None
