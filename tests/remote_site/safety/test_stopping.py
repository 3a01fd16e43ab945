"""The jerk-limited stop: as quick as the limits allow, and never beyond them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remote_site.safety.stopping import advance, joint_stop, longest_stop, span

DT = 0.004


@pytest.mark.parametrize(
    ("velocity", "acceleration", "seconds", "travel"),
    [(0.5, 0.0, 0.1414, 0.0354), (1.0, 0.0, 0.2, 0.1), (2.5, 0.0, 0.35, 0.4375), (0.5, 10.0, 0.3, 0.1833)],
)
def test_stop_times_at_10_rad_s2_and_100_rad_s3(velocity, acceleration, seconds, travel):
    for side in (1, -1):
        stop = joint_stop((0.0, side * velocity, side * acceleration), 10.0, 100.0)
        assert stop.duration == pytest.approx(seconds, abs=1e-3)
        assert stop.end == pytest.approx(side * travel, abs=1e-4)


@pytest.mark.parametrize(
    ("velocity", "acceleration", "jerk", "seconds"),
    [
        (3.14159, 10.0, 1000.0, 0.334),
        (3.14159, 10.0, 100.0, 0.514),
        (3.14159, 20.0, 1.0, 7.09),
        (2.0, 0.01, 1e3, 200.0),
    ],
)
def test_the_longest_stop_of_some_limits(velocity, acceleration, jerk, seconds):
    assert longest_stop(velocity, acceleration, jerk) == pytest.approx(seconds, rel=2e-3)


bounds = st.tuples(st.floats(0.1, 5.0), st.floats(0.1, 25.0), st.floats(0.5, 2000.0))


@settings(max_examples=300, deadline=None, derandomize=True)
@given(bounds, st.floats(-1, 1), st.floats(-1, 1))
def test_no_motion_that_the_guard_lets_pass_takes_longer_to_stop(limits, speed, rise):
    velocity, acceleration, jerk = limits
    state = (0.0, speed * velocity, rise * acceleration)
    taken_back = state[1] + state[2] * abs(state[2]) / (2 * jerk)
    if abs(taken_back) <= velocity:
        assert joint_stop(state, acceleration, jerk).duration <= longest_stop(*limits) + 1e-9


@settings(max_examples=100, deadline=None, derandomize=True)
@given(bounds)
def test_one_motion_that_the_guard_lets_pass_takes_as_long(limits):
    velocity, acceleration, jerk = limits
    rise = min(acceleration, 2 * np.sqrt(jerk * velocity))
    state = (0.0, velocity - rise * rise / (2 * jerk), rise)
    assert joint_stop(state, acceleration, jerk).duration == pytest.approx(longest_stop(*limits))


states = st.tuples(st.floats(-1, 1), st.floats(-3, 3), st.floats(-10, 10))


@settings(max_examples=300, deadline=None, derandomize=True)
@given(states, st.sampled_from([100.0, 1000.0]))
def test_a_stop_reaches_rest_continuously_within_acceleration_and_extent(state, jerk):
    stop = joint_stop(state, 10.0, jerk)
    times = np.linspace(0, stop.duration, 200)
    q, v, a = np.array([stop.at(t) for t in times]).T
    low, high = stop.extent()
    assert low - 1e-9 <= q.min()
    assert q.max() <= high + 1e-9
    # the extent is reached, not merely a bound
    assert q.min() - low < 1e-3 * max(1.0, abs(low))
    assert high - q.max() < 1e-3 * max(1.0, abs(high))
    assert np.abs(a).max() <= 10.0 + 1e-9
    step = stop.duration / 199
    assert np.abs(np.diff(a)).max() <= jerk * step * 1.001 + 1e-9
    assert np.abs(np.diff(v)).max() <= 10.0 * step * 1.001 + 1e-9
    assert stop.at(stop.duration + 1.0) == (pytest.approx(stop.end), 0.0, 0.0)
    before_the_end = stop.at(max(stop.duration - 1e-9, 0.0))
    assert before_the_end[1] == pytest.approx(0.0, abs=1e-6)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(states)
def test_stepping_replans_the_same_stop(state):
    whole = joint_stop(state, 10.0, 300.0)
    here = state
    for k in range(1, 1 + int(whole.duration / DT) + 1):
        here = joint_stop(here, 10.0, 300.0).at(DT)
        assert here == pytest.approx(whole.at(k * DT), abs=1e-6)
    assert here[1:] == (0.0, 0.0)
    assert here[0] == pytest.approx(whole.end, abs=1e-8)


def test_constant_jerk_is_integrated_exactly():
    assert advance((1.0, 2.0, 3.0), 6.0, 0.5) == pytest.approx((1 + 1 + 0.375 + 0.125, 2 + 1.5 + 0.75, 6.0))


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.floats(-3, 3), st.floats(-10, 10))
def test_no_stop_is_faster_than_its_bound(v, a):
    stop = joint_stop((0.0, v, a), 10.0, 1000.0)
    assert all(abs(stop.at(t)[1]) <= stop.fastest + 1e-9 for t in np.linspace(0, stop.duration, 40))


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("jerk", [100.0, 1000.0])
def test_a_joint_that_still_becomes_faster_reaches_the_bound_of_its_speed(side, jerk):
    stop = joint_stop((0.0, side * 0.5, side * 8.0), 10.0, jerk)
    speeds = [abs(stop.at(t)[1]) for t in (*np.linspace(0.0, stop.duration, 100), 8.0 / jerk)]
    assert max(speeds) == pytest.approx(stop.fastest)
    assert stop.fastest == pytest.approx(0.5 + 32.0 / jerk)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("left", [0.2, 0.3, 0.35, 0.4, 0.45, 0.49])
def test_a_stop_that_brakes_harder_than_it_needs_to_is_within_its_span(side, left):
    """It comes back a little, or far, while the acceleration is taken back."""
    for jerk in (100.0, 1000.0):
        state = (0.0, side * left * 100.0 / jerk, -side * 10.0)
        stop, (middle, reach) = joint_stop(state, 10.0, jerk), span(state, 10.0, jerk)
        low, high = stop.extent()
        assert stop.reverses is False or side * stop.end < max(side * low, side * high)
        assert middle - reach - 1e-9 <= low
        assert high <= middle + reach + 1e-9


@settings(max_examples=500, deadline=None, derandomize=True)
@given(states, st.sampled_from([100.0, 1000.0]))
def test_a_stop_lies_within_its_span_and_reverses_only_when_it_says_so(state, jerk):
    stop = joint_stop(state, 10.0, jerk)
    middle, reach = span(state, 10.0, jerk)
    low, high = stop.extent()
    assert middle - reach - 1e-9 <= low
    assert high <= middle + reach + 1e-9
    if not stop.reverses:
        assert high - low == pytest.approx(abs(stop.end - stop.q), abs=1e-9)
