"""A silent process is distinguished from one that was not listened to, and not only by one that listens in time."""

import pytest

from common.clock import NS_PER_MS
from remote_site.safety.silence import Silence


def heard(looks_ms, last_ms=0):
    silence = Silence(50 * NS_PER_MS)
    return [silence.of(last_ms * NS_PER_MS, look * NS_PER_MS) // NS_PER_MS for look in looks_ms]


def test_silence_is_the_time_since_the_last_word():
    assert heard([10, 40, 80, 120]) == [10, 40, 80, 120]


def test_a_pause_of_the_listener_is_no_silence():
    assert heard([10, 20, 71, 100, 150, 171]) == [10, 20, 20, 49, 99, 120]
    assert heard([10, 1010, 1012, 1060]) == [10, 10, 12, 60]


def test_a_word_after_the_pause_counts_from_itself():
    assert heard([10, 200, 240], last_ms=230)[-1] == 10


def test_a_word_within_a_pause_is_as_if_it_had_just_come():
    silence = Silence(50 * NS_PER_MS)
    silence.of(0, 10 * NS_PER_MS)
    assert silence.of(60 * NS_PER_MS, 210 * NS_PER_MS) == 0
    assert silence.of(60 * NS_PER_MS, 240 * NS_PER_MS) == 30 * NS_PER_MS


@pytest.mark.parametrize("turn_ms", [51, 60, 90, 400])
def test_a_listener_that_is_always_late_notices_after_four_turns(turn_ms):
    assert heard(range(0, 6 * turn_ms, turn_ms)) == [0, 0, 50, 100, 150, 200]


@pytest.mark.parametrize(("listened_ms", "counted_ms"), [(499, 50), (500, 0)])
def test_a_pause_counts_until_the_listener_has_listened_in_time_for_ten_of_them(listened_ms, counted_ms):
    in_time = range(100 + listened_ms % 50, 101 + listened_ms, 50)
    assert heard([0, 100, *in_time, 800])[-1] == listened_ms + counted_ms


@pytest.mark.parametrize("between_ms", [1, 10, 40])
def test_turns_in_time_between_late_ones_are_no_excuse(between_ms):
    looks, now = [], 0
    for _ in range(20):
        looks += [now + 60, now + 60 + between_ms]
        now = looks[-1]
    assert heard(looks)[7] > 100


@pytest.mark.parametrize("every_ms", [600, 1000, 5000])
def test_a_pause_now_and_then_blames_nobody_who_speaks_after_each(every_ms):
    silence, looked, worst = Silence(50 * NS_PER_MS), [], 0
    for begin in range(1000, 60_000, every_ms):
        looked += [*range(begin, begin + every_ms - 300, 2), begin + every_ms - 1]  # the last after 300 ms
    for look in looked:
        worst = max(worst, silence.of((look - look % every_ms % 10 - 2) * NS_PER_MS, look * NS_PER_MS))
    assert worst < 20 * NS_PER_MS


def test_after_a_pause_the_other_has_as_long_as_ever_to_speak():
    silence = Silence(50 * NS_PER_MS)
    for look in range(0, 700, 2):
        silence.of((look - 2) * NS_PER_MS, look * NS_PER_MS)
    after = [silence.of(696 * NS_PER_MS, look * NS_PER_MS) for look in range(1700, 1796, 2)]
    assert max(after) < 100 * NS_PER_MS


def test_a_pause_before_the_last_word_shortens_no_silence_after_it():
    silence = Silence(50 * NS_PER_MS)
    for look, last in ((10, 0), (1010, 0), (1012, 1011)):
        silence.of(last * NS_PER_MS, look * NS_PER_MS)
    later = [silence.of(1011 * NS_PER_MS, look * NS_PER_MS) for look in (1050, 1090, 1131)]
    assert later == [39 * NS_PER_MS, 79 * NS_PER_MS, 120 * NS_PER_MS]
