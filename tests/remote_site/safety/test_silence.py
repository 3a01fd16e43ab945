"""A silent process is distinguished from one that was not listened to."""

from common.clock import NS_PER_MS
from remote_site.safety.silence import Silence


def heard(looks_ms, last_ms=0):
    silence = Silence(50 * NS_PER_MS)
    return [silence.of(last_ms * NS_PER_MS, look * NS_PER_MS) // NS_PER_MS for look in looks_ms]


def test_silence_is_the_time_since_the_last_word():
    assert heard([10, 40, 80, 120]) == [10, 40, 80, 120]


def test_after_a_pause_of_the_listener_silence_counts_anew():
    assert heard([10, 20, 71, 100, 150, 171]) == [10, 20, 0, 29, 79, 100]


def test_a_word_after_the_pause_counts_from_itself():
    assert heard([10, 200, 240], last_ms=230)[-1] == 10
