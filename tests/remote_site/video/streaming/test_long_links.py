"""Over long ways only what waits counts as late: neither propagation, nor a way that becomes longer, nor a pause."""

import itertools

import numpy as np
import pytest

from lab.measure.video.link import MAKE_AND_PAINT_MS, Arrival, StreamRun
from remote_site.video.streaming.link_rate import LATE_MS, Least, LinkRate
from remote_site.video.streaming.sent_pictures import Arrivals
from tests.remote_site.video.streaming.test_h264_adaptation import settings, through

MS, REPORT_NS = 1_000_000, 100_000_000


def over(delay_ms: float, mbit_s: float) -> StreamRun:
    run = through(mbit_s)
    run.link.delay_ms = delay_ms
    return run


def fps(arrivals: list[Arrival], seconds: float) -> float:
    return len(arrivals) / seconds / 4


def waited_ms(run: StreamRun, arrivals: list[Arrival], percentile: float) -> float:
    """How long pictures were under way beyond the link's own delay."""
    ages = [arrival.age_ms - MAKE_AND_PAINT_MS for arrival in arrivals]
    return float(np.percentile(ages, percentile)) - run.link.delay_ms


@pytest.mark.slow
@pytest.mark.parametrize(("delay_ms", "mbit_s"), list(itertools.product((0.0, 40.0, 120.0), (2.0, 5.0, 20.0))))
def test_the_same_rate_carries_the_same_pictures_however_long_the_way(delay_ms: float, mbit_s: float) -> None:
    run = over(delay_ms, mbit_s)
    run.run(6.0)
    arrivals = run.run(15.0)
    assert fps(arrivals, 15.0) > 25.0
    assert {setting.scale for setting in settings(run)} == {1.0}
    assert waited_ms(run, arrivals, 50) < 20.0
    assert waited_ms(run, arrivals, 95) < 150.0 + 2 * delay_ms


@pytest.mark.parametrize("delay_ms", [20.0, 80.0])
def test_two_seconds_after_a_fall_from_20_to_2_mbit_the_pictures_are_young_again(delay_ms: float) -> None:
    run = over(delay_ms, 20.0)
    run.run(10.0)
    run.link.mbit_s = 2.0
    run.run(2.5)
    arrivals = run.run(6.0)
    assert waited_ms(run, arrivals, 95) < 250.0
    assert fps(arrivals, 6.0) > 25.0


@pytest.mark.parametrize(("before_ms", "after_ms"), [(20.0, 60.0), (20.0, 120.0), (120.0, 20.0)])
def test_a_way_that_becomes_longer_is_no_full_link(before_ms: float, after_ms: float) -> None:
    run = over(before_ms, 20.0)
    run.run(10.0)
    run.link.delay_ms = after_ms
    run.run(1.0)
    assert fps(run.run(8.0), 8.0) > 28.0
    assert {setting.scale for setting in settings(run)} == {1.0}


def test_a_picture_that_does_not_come_is_late_before_it_has_come() -> None:
    rate = LinkRate()
    for k in range(20):
        stopped = max(0, k - 9) * 100.0
        arrivals = Arrivals(10_000, 0 if stopped else 10_000, 10_000, 50.0, 100.0, 90.0 + stopped)
        rate.report(arrivals, 1e6, k * REPORT_NS, cautious=True)
        assert (rate.draining < 1.0) == (stopped - 10.0 > LATE_MS + 20.0)
    assert rate.carries is not None


def test_a_pause_of_the_congestion_control_is_no_full_link() -> None:
    rate = LinkRate()
    for k in range(60):
        late_ms = {30: 100.0, 31: 200.0, 32: 250.0, 33: 150.0}.get(k, 0.0)
        arrivals = Arrivals(10_000, 2_000 if late_ms else 10_000, 20_000, 120.0 + late_ms, 240.0 + late_ms, 0.0)
        rate.report(arrivals, 1e6, k * REPORT_NS, cautious=True)
    assert rate.carries is None


def test_the_least_is_that_of_the_last_twenty_seconds() -> None:
    least = Least()
    assert [least.see(value, k * 1000 * MS) for k, value in enumerate([5.0, 3.0, 4.0])] == [5.0, 3.0, 3.0]
    assert least.see(9.0, 19_000 * MS) == 3.0
    assert least.see(9.0, 40_000 * MS) == 9.0
