"""Paths of the tool, the approach to them, and the time on them."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.errors import ConfigError
from common.geometry import angle_between, rotation_from_vector, transform
from local_site.programmed.approach import LONGEST_M, SPEED_M_S, SPEED_RAD_S, approach, why_too_far
from local_site.programmed.path_progress import ACCELERATION_PER_S, PathClock
from local_site.programmed.tool_trajectory import ToolTrajectory

DT_S = 1 / 60
TRIPLE = st.tuples(*[st.floats(-0.6, 0.6)] * 3)


def line(times=(0.0, 1.0, 3.0), **more):
    n = len(times)
    positions, orientations = np.zeros((n, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    positions[:, 0] = np.linspace(0.0, 1.0, n)
    return ToolTrajectory(np.array(times), positions, orientations, **more)


def test_a_path_is_linear_between_its_times_and_stands_outside():
    path = line()
    assert path.duration_s == 3.0
    for t_s, x in [(-1.0, 0.0), (0.5, 0.25), (2.0, 0.75), (9.0, 1.0)]:
        assert path.base_T_tool(t_s)[0, 3] == pytest.approx(x)


@pytest.mark.parametrize("times", [(0.0,), (0.5, 1.0), (0.0, 0.0, 1.0), (0.0, 2.0, 1.0)])
def test_what_is_no_path_is_refused(times):
    with pytest.raises(ConfigError, match="two times or more"):
        line(times)


def test_a_path_with_numbers_that_are_not_finite_is_refused():
    with pytest.raises(ConfigError, match="finite"):
        ToolTrajectory(
            np.array([0.0, 1.0]), np.array([[0, 0, 0], [np.nan, 0, 0]]), np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))
        )


@pytest.mark.slow
@given(TRIPLE, TRIPLE)
def test_an_approach_is_slow_straight_and_ends_where_the_path_begins(way, turn):
    begin, end = np.eye(4), transform(rotation_from_vector(np.array(turn)), np.array(way))
    path = approach(begin, end)
    poses = [path.base_T_tool(t_s) for t_s in np.linspace(0.0, path.duration_s, 200)]
    step_s = path.duration_s / 199
    assert poses[0] == pytest.approx(begin)
    assert poses[-1] == pytest.approx(end, abs=1e-9)
    for before, after in pairwise(poses):
        assert np.linalg.norm(after[:3, 3] - before[:3, 3]) <= 1.01 * SPEED_M_S * step_s
        assert angle_between(before[:3, :3], after[:3, :3]) <= 1.01 * SPEED_RAD_S * step_s + 1e-7
        assert np.linalg.norm(np.cross(after[:3, 3], end[:3, 3])) < 1e-9


def run(clock, seconds, speed, stop_at_s):
    """The rates of each step, and when it arrived."""
    rates, arrived = [clock.rate], None
    for step in range(round(seconds / DT_S)):
        if clock.advance(DT_S, speed, stop_at_s) and arrived is None:
            arrived = (step + 1) * DT_S
        rates.append(clock.rate)
    return np.array(rates), arrived


@pytest.mark.parametrize("speed", [0.3, 1.0, 2.0])
def test_the_clock_starts_and_stops_smoothly_where_it_should(speed):
    clock = PathClock()
    rates, arrived = run(clock, 12.0, speed, 2.0)
    assert clock.t_s == 2.0
    assert clock.rate == 0.0
    assert max(rates) <= speed + 1e-9
    moving = rates[: np.argmax(rates)]
    assert np.all(np.diff(moving) <= ACCELERATION_PER_S * DT_S + 1e-9)
    assert 2.0 / speed <= arrived < 2.0 / speed + 2.0


def test_the_clock_turns_back_and_stands_without_passing():
    clock = PathClock()
    run(clock, 3.0, 1.0, 2.0)
    rates, arrived = run(clock, 4.0, 1.0, 0.5)
    assert arrived is not None
    assert clock.t_s == 0.5
    assert min(rates) < -0.9
    clock.begin(0.0)
    run(clock, 1.0, 1.0, 5.0)
    rates, _ = run(clock, 1.0, 1.0, None)
    assert rates[-1] == 0.0
    assert np.all(np.diff(rates) <= 1e-9)


def test_an_approach_to_where_no_arm_reaches_is_refused():
    far = transform(np.eye(3), np.array([1e6, 0.0, 0.0]))
    assert "1000000 m away" in why_too_far(np.eye(4), far)
    with pytest.raises(ConfigError, match="is it a path of this cell"):
        approach(np.eye(4), far)
    longest = approach(np.eye(4), transform(np.eye(3), np.array([LONGEST_M, 0.0, 0.0])))
    assert len(longest.t_s) < 20_000
