"""The pace of the control loop: absolute deadlines, misses, distance after a late tick."""

from itertools import pairwise

import pytest

from common.clock import NS_PER_MS, FakeClock
from remote_site.runtime.rate import Rate, percentile_of


def test_a_rate_keeps_absolute_deadlines_and_counts_what_it_missed() -> None:
    clock = FakeClock()
    rate = Rate(250.0, clock)
    assert [rate.wait() for _ in range(3)] == [4 * NS_PER_MS, 8 * NS_PER_MS, 12 * NS_PER_MS]
    clock.advance_ms(9.0)
    rate.wait()
    assert rate.missed == 1
    assert rate.late_us(100) == pytest.approx(5000.0)
    assert rate.wait() == 24 * NS_PER_MS


def test_a_rate_keeps_its_distance_after_a_late_tick() -> None:
    clock = FakeClock()
    rate = Rate(250.0, clock, least_fraction=0.9)
    rate.wait()
    woken = []
    for late_ms in (0.0, 0.3, 3.9, 0.0, 9.0, 0.0, 0.0):
        rate_due_ns = rate.next_ns
        clock.sleep_until_ns(rate_due_ns + round(late_ms * NS_PER_MS))
        rate.wait()
        woken.append(clock.now_ns())
    spaces = [(later - sooner) / NS_PER_MS for sooner, later in pairwise(woken)]
    assert spaces == pytest.approx([4.3, 7.6, 3.6, 13.0, 3.6, 4.0])
    assert rate.missed == 2


def test_percentiles_are_nearest_rank() -> None:
    assert percentile_of([], 99) == 0.0
    assert percentile_of([1.0, 2.0, 3.0, 4.0], 50) == 3.0
    assert percentile_of([1.0, 2.0, 3.0, 4.0], 100) == 4.0
