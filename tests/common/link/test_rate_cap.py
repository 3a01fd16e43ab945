"""How fast messages are taken: a burst after a delay passes immediately, a flood at the cap, and is reported once."""

import pytest

from common.clock import NS_PER_S
from common.link.rate_cap import RateCap

HZ, BURST = 100.0, 5
PERIOD_NS = round(NS_PER_S / HZ)


def taken(cap: RateCap, waiting: int, now_ns: int) -> int:
    """When the last of this many waiting messages has been taken."""
    for _ in range(waiting):
        now_ns += cap.pause_ns(now_ns)
        cap.passed(now_ns)
    return now_ns


def test_as_many_as_may_wait_pass_at_once() -> None:
    cap = RateCap(HZ, BURST)
    assert taken(cap, BURST, NS_PER_S) == NS_PER_S


@pytest.mark.parametrize("waiting", [BURST + 1, 10 * BURST])
def test_more_pass_at_the_cap(waiting: int) -> None:
    cap = RateCap(HZ, BURST)
    assert taken(cap, waiting, NS_PER_S) == NS_PER_S + (waiting - BURST) * PERIOD_NS


def test_what_comes_no_faster_than_the_cap_never_waits() -> None:
    cap = RateCap(HZ, 2)
    for k in range(1000):
        assert cap.pause_ns(k * PERIOD_NS) == 0
        cap.passed(k * PERIOD_NS)


def test_room_for_a_burst_comes_back() -> None:
    cap = RateCap(HZ, BURST)
    calm_ns = taken(cap, 10 * BURST, NS_PER_S) + BURST * PERIOD_NS
    assert taken(cap, BURST, calm_ns) == calm_ns


def test_a_flood_is_one_that_lasts_and_is_over_once_it_is_calm_for_as_long() -> None:
    cap = RateCap(HZ, BURST)
    now_ns = taken(cap, round(HZ), NS_PER_S)
    assert not cap.flooded
    now_ns = taken(cap, BURST, now_ns)
    assert cap.flooded
    for _ in range(round(HZ)):
        assert cap.flooded
        now_ns = taken(cap, 1, now_ns + NS_PER_S)
    assert not cap.flooded
