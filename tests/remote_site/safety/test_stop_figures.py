"""The time and the way of an arm's stops: no motion that the guard lets pass exceeds them, and some reach them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remote_site.kinematics.limits import JointLimits
from remote_site.safety.stop_figures import rising_stop, steady_stop, way
from remote_site.safety.stopping import joint_stop

bounds = st.tuples(st.floats(0.1, 5.0), st.floats(0.1, 25.0), st.floats(0.5, 2000.0))


def limits(*joints):
    velocity, acceleration, jerk = (np.array(column) for column in zip(*joints, strict=True))
    names = tuple(f"j{k}" for k in range(len(joints)))
    return JointLimits(names, np.full(len(joints), -9.0), np.full(len(joints), 9.0), velocity, acceleration, jerk)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(bounds, st.floats(-1, 1), st.floats(-1, 1))
def test_no_motion_that_the_guard_lets_pass_goes_on_longer_or_further(bound, speed, rise):
    velocity, acceleration, jerk = bound
    state = (0.0, speed * velocity, rise * acceleration)
    taken_back = state[1] + state[2] * abs(state[2]) / (2 * jerk)
    if abs(taken_back) <= velocity:
        stop, figures = joint_stop(state, acceleration, jerk), rising_stop(limits(bound), [1.0], velocity)
        assert stop.duration <= figures.seconds + 1e-9
        assert abs(stop.end) <= figures.by_one_m + 1e-9


@pytest.mark.parametrize("bound", [(1.0, 20.0, 50.0), (3.0, 10.0, 1000.0), (3.0, 10.0, 100.0), (0.1, 25.0, 40.0)])
def test_one_motion_that_the_guard_lets_pass_goes_on_as_far(bound):
    """From the greatest acceleration that is taken back at full speed and does not need a speed backwards before."""
    velocity, acceleration, jerk = bound
    rises = np.linspace(0.0, min(acceleration, np.sqrt(2 * jerk * velocity)), 200)
    ends = [joint_stop((0.0, velocity - a * a / (2 * jerk), a), acceleration, jerk).end for a in rises]
    assert rising_stop(limits(bound), [0.5], 9.0).by_one_m == pytest.approx(0.5 * max(ends))


def test_at_10_rad_s2_and_100_rad_s3():
    figures = steady_stop(limits((3.0, 10.0, 100.0)), [0.7], 2.5)
    assert figures == pytest.approx((0.350, 0.306, 0.306), rel=2e-3)
    assert rising_stop(limits((3.0, 10.0, 100.0)), [0.7], 2.5) == pytest.approx((0.450, 0.470, 0.470), rel=2e-3)


def test_the_slowest_the_furthest_and_the_sum_of_all_joints_are_told():
    quick, slow = (3.0, 20.0, 1000.0), (1.0, 5.0, 1000.0)
    stops = [steady_stop(limits(joint), [1.0], 9.0) for joint in (quick, slow)]
    both = steady_stop(limits(quick, slow), [0.1, 2.0], 9.0)
    assert both.seconds == max(stop.seconds for stop in stops)
    ways = 0.1 * stops[0].by_one_m, 2.0 * stops[1].by_one_m
    assert both[1:] == pytest.approx((max(ways), sum(ways)))
    assert way(limits(quick, slow), [0.1, 2.0], 2.0, 0.5) == pytest.approx((1.0, 1.1))
