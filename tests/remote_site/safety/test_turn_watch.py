"""A loop that is always late is told from one that was once kept waiting."""

import pytest

from common.clock import NS_PER_MS
from remote_site.safety.turn_watch import TurnWatch


def watched(turns_ms):
    """What is told after each of these turns, ms."""
    watch, now_ms, told = TurnWatch(), 1000.0, []
    watch.note(round(now_ms * NS_PER_MS))
    for turn_ms in turns_ms:
        now_ms += turn_ms
        watch.note(round(now_ms * NS_PER_MS))
        told.append(watch.slow_ns / NS_PER_MS)
    return told


@pytest.mark.parametrize("turn_ms", [51.0, 60.0, 90.0, 300.0])
def test_turns_that_are_always_too_long_are_told_after_a_second_and_five_of_them(turn_ms):
    told = watched([4.0] * 10 + [turn_ms] * 30)
    first = next(k for k, slow in enumerate(told) if slow)
    turns = first - 9
    assert turns == max(5, -(-1000 // turn_ms))
    assert all(slow == pytest.approx(turn_ms) for slow in told[first:])


def test_the_mean_of_uneven_turns_is_told():
    assert watched([60.0, 90.0] * 10)[-1] == pytest.approx(75.0)


@pytest.mark.parametrize("turns_ms", [[5000.0], [400.0] * 4, [50.0] * 200, [60.0] * 10 + [4.0] + [60.0] * 16])
def test_pauses_turns_at_the_limit_and_late_ones_between_others_are_not(turns_ms):
    assert not any(watched(turns_ms))


def test_a_turn_in_time_ends_it():
    told = watched([60.0] * 20 + [4.0, 60.0])
    assert told[19]
    assert told[20:] == [0.0, 0.0]


def test_how_long_the_last_turn_took_is_told():
    watch = TurnWatch()
    assert (watch.took_ns, watch.slow_ns) == (0, 0)
    watch.note(10 * NS_PER_MS)
    assert watch.took_ns == 0
    watch.note(14 * NS_PER_MS)
    assert watch.took_ns == 4 * NS_PER_MS
