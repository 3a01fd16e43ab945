"""How fast messages may be taken: what delay has bunched passes at once, a flood at the cap, and it is told once."""

import pytest

from common.clock import NS_PER_S
from common.pace import Pace

HZ, BURST = 100.0, 5
PERIOD_NS = round(NS_PER_S / HZ)


def taken(pace: Pace, waiting: int, now_ns: int) -> int:
    """When the last of so many messages that wait has been taken."""
    for _ in range(waiting):
        now_ns += pace.pause_ns(now_ns)
        pace.passed(now_ns)
    return now_ns


def test_as_many_as_may_wait_pass_at_once() -> None:
    pace = Pace(HZ, BURST)
    assert taken(pace, BURST, NS_PER_S) == NS_PER_S


@pytest.mark.parametrize("waiting", [BURST + 1, 10 * BURST])
def test_more_pass_at_the_cap(waiting: int) -> None:
    pace = Pace(HZ, BURST)
    assert taken(pace, waiting, NS_PER_S) == NS_PER_S + (waiting - BURST) * PERIOD_NS


def test_what_comes_no_faster_than_the_cap_never_waits() -> None:
    pace = Pace(HZ, 2)
    for k in range(1000):
        assert pace.pause_ns(k * PERIOD_NS) == 0
        pace.passed(k * PERIOD_NS)


def test_room_for_a_burst_comes_back() -> None:
    pace = Pace(HZ, BURST)
    calm_ns = taken(pace, 10 * BURST, NS_PER_S) + BURST * PERIOD_NS
    assert taken(pace, BURST, calm_ns) == calm_ns


def test_a_flood_is_one_that_lasts_and_is_over_once_it_is_calm_for_as_long() -> None:
    pace = Pace(HZ, BURST)
    now_ns = taken(pace, round(HZ), NS_PER_S)
    assert not pace.flooded
    now_ns = taken(pace, BURST, now_ns)
    assert pace.flooded
    for _ in range(round(HZ)):
        assert pace.flooded
        now_ns = taken(pace, 1, now_ns + NS_PER_S)
    assert not pace.flooded
