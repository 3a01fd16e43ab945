"""The offset between two hosts' clocks: true within its stated uncertainty, whatever path and wall clock do."""

import itertools
import random
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.clock import NS_PER_MS, NS_PER_S, OffsetEstimator, RoundTrip
from common.host_clock import MonotonicClock
from tests.present import present

HOUR_NS = 3600 * NS_PER_S


def trip(t_ns, offset_ns, there_ns, back_ns, answering_ns=0):
    """A question asked at `t_ns` by our clock; the other shows `offset_ns` more."""
    received_ns = t_ns + there_ns + offset_ns
    return RoundTrip(t_ns, received_ns, received_ns + answering_ns, t_ns + there_ns + answering_ns + back_ns)


def test_equal_ways_give_the_offset_exactly():
    one = trip(1000, -HOUR_NS, 200, 200, answering_ns=50)
    assert (one.offset_ns, one.duration_ns) == (-HOUR_NS, 400)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    st.integers(-HOUR_NS, HOUR_NS),
    st.lists(st.tuples(st.integers(0, 400 * NS_PER_MS), st.integers(0, 400 * NS_PER_MS)), min_size=1, max_size=60),
)
def test_the_error_never_exceeds_the_uncertainty_however_uneven_the_ways(offset_ns, ways):
    estimator, now_ns = OffsetEstimator(), 10 * NS_PER_S
    for there_ns, back_ns in ways:
        one = trip(now_ns, offset_ns, there_ns, back_ns)
        estimator.add(one)
        now_ns = one.reply_ns + 100 * NS_PER_MS
        known = present(estimator.estimate(now_ns))
        assert abs(known.offset.offset_ns - offset_ns) <= known.offset.uncertainty_ns


def test_the_quickest_round_trip_counts_and_its_half_is_the_uncertainty():
    estimator = OffsetEstimator()
    for k, way_ms in enumerate((30, 2, 25)):
        estimator.add(trip(k * 200 * NS_PER_MS, 7 * NS_PER_S, way_ms * NS_PER_MS, way_ms * NS_PER_MS))
    known = present(estimator.estimate(450 * NS_PER_MS))
    assert known.offset.offset_ns == 7 * NS_PER_S
    assert known.offset.uncertainty_ns == pytest.approx(2 * NS_PER_MS, abs=0.6 * NS_PER_MS)


def test_under_jitter_of_20_ms_each_way_it_errs_by_a_few_milliseconds():
    draw = random.Random(4)  # noqa: S311  # jitter, not secrets
    estimator, errors = OffsetEstimator(), []
    for k in range(300):
        there, back = (round((20 + draw.uniform(0, 20)) * NS_PER_MS) for _ in range(2))
        estimator.add(trip(k * 200 * NS_PER_MS, HOUR_NS, there, back))
        known = present(estimator.estimate(k * 200 * NS_PER_MS + there + back))
        errors.append((known.offset.offset_ns - HOUR_NS) / NS_PER_MS)
    assert (sum(e * e for e in errors[20:]) / len(errors[20:])) ** 0.5 < 4


def test_without_round_trips_for_four_seconds_nothing_is_known():
    estimator = OffsetEstimator()
    assert estimator.estimate(0) is None
    estimator.add(trip(0, 5, 100, 100))
    assert present(estimator.estimate(4 * NS_PER_S)).measured_ns == 105
    assert estimator.estimate(4 * NS_PER_S + 201) is None


def test_uncertainty_grows_by_the_dispersion_while_nothing_new_is_heard():
    estimator = OffsetEstimator()
    estimator.add(trip(0, 5, 100, 100))
    first, later = (present(estimator.estimate(now_ns)).offset for now_ns in (200, 2 * NS_PER_S))
    grown = later.uncertainty_ns - first.uncertainty_ns
    assert grown == pytest.approx(4_000_000, abs=100)


def test_where_the_link_becomes_slower_the_uncertainty_rises_gently_to_what_can_be_measured():
    estimator, known_ms = OffsetEstimator(), []
    for k in range(600):
        t_ns, way_ns = k * 200 * NS_PER_MS, (20 if k < 50 else 120) * NS_PER_MS
        estimator.add(trip(t_ns, HOUR_NS, way_ns, way_ns))
        known = present(estimator.estimate(t_ns + 2 * way_ns)).offset
        assert known.offset_ns == HOUR_NS
        known_ms.append(known.uncertainty_ns / NS_PER_MS)
    assert known_ms[49] == pytest.approx(20, abs=0.1)
    assert max(b - a for a, b in itertools.pairwise(known_ms)) < 1
    assert known_ms[-1] == pytest.approx(120, abs=0.1)


def test_a_small_step_of_a_clock_is_noticed_however_long_the_best_round_trip_is_ago():
    estimator = OffsetEstimator()
    estimator.add(trip(0, HOUR_NS, 1000, 1000))
    for k in range(1, 300):
        estimator.add(trip(k * 200 * NS_PER_MS, HOUR_NS, 20 * NS_PER_MS, 20 * NS_PER_MS))
    estimator.add(trip(61 * NS_PER_S, HOUR_NS + 40 * NS_PER_MS, 20 * NS_PER_MS, 20 * NS_PER_MS))
    assert present(estimator.estimate(61 * NS_PER_S + 40 * NS_PER_MS)).offset.offset_ns == HOUR_NS + 40 * NS_PER_MS


def test_a_clock_that_starts_anew_replaces_the_estimate_at_once():
    estimator = OffsetEstimator()
    estimator.add(trip(NS_PER_S, HOUR_NS, 100, 100))
    estimator.add(trip(NS_PER_S + 200 * NS_PER_MS, -HOUR_NS, 5 * NS_PER_MS, 5 * NS_PER_MS))
    assert present(estimator.estimate(2 * NS_PER_S)).offset.offset_ns == -HOUR_NS


@pytest.mark.parametrize("times", [(100, 0, 50, 90), (0, 60, 50, 100), (0, 10, 200, 100)])
def test_times_that_no_clocks_can_tell_are_left_out(times):
    estimator = OffsetEstimator()
    estimator.add(RoundTrip(*times))
    assert estimator.estimate(200) is None


@pytest.mark.parametrize("step_s", [3600.0, -3600.0])
def test_wall_clock_steps_change_nothing(monkeypatch, step_s):
    clock, estimator = MonotonicClock(), OffsetEstimator()
    real_time, real_time_ns = time.time, time.time_ns
    before_ns = clock.now_ns()
    for k in range(40):
        if k == 20:
            monkeypatch.setattr(time, "time", lambda: real_time() + step_s)
            monkeypatch.setattr(time, "time_ns", lambda: real_time_ns() + round(step_s * NS_PER_S))
        asked_ns = clock.now_ns()
        received_ns = clock.now_ns()
        estimator.add(RoundTrip(asked_ns, received_ns, clock.now_ns(), clock.now_ns()))
    now_ns = clock.now_ns()
    known = present(estimator.estimate(now_ns))
    assert abs(known.offset.offset_ns) <= known.offset.uncertainty_ns < NS_PER_S
    assert 0 <= now_ns - before_ns < HOUR_NS
