"""A replay's time: it goes on at a speed, pauses, jumps, and stands at the recording's end."""

import pytest

from common.clock import NS_PER_S, FakeClock
from farhand.replay.playback import Playback

BEGIN_NS, SECONDS = 5_000_000_000_000, 60.0


@pytest.fixture
def clock():
    return FakeClock(77 * NS_PER_S)


@pytest.fixture
def playback(clock):
    return Playback(clock, BEGIN_NS, BEGIN_NS + round(SECONDS * NS_PER_S))


def position_s(playback):
    return (playback.now_ns() - BEGIN_NS) / NS_PER_S


def test_it_begins_at_the_beginning_and_goes_on_at_the_recordings_pace(clock, playback):
    assert position_s(playback) == 0.0
    clock.advance_ms(2500)
    assert position_s(playback) == 2.5
    assert playback.is_running


def test_another_speed_counts_from_where_it_is_set(clock, playback):
    clock.advance_ms(1000)
    playback.accelerate(4.0)
    clock.advance_ms(1000)
    assert position_s(playback) == 5.0
    playback.accelerate(0.5)
    clock.advance_ms(1000)
    assert position_s(playback) == 5.5


def test_a_pause_holds_the_time(clock, playback):
    clock.advance_ms(1000)
    playback.play(playing=False)
    clock.advance_ms(9000)
    assert position_s(playback) == 1.0
    assert not playback.is_running
    playback.play(playing=True)
    clock.advance_ms(500)
    assert position_s(playback) == 1.5


@pytest.mark.parametrize(("asked_s", "shown_s"), [(30.0, 30.0), (-3.0, 0.0), (999.0, SECONDS)])
def test_a_jump_stays_within_the_recording_and_is_counted(playback, asked_s, shown_s):
    playback.jump(BEGIN_NS + round(asked_s * NS_PER_S))
    assert position_s(playback) == shown_s
    assert playback.jumps == 1


def test_it_stands_at_the_end_and_begins_again_when_played(clock, playback):
    clock.advance_ms(1000 * SECONDS + 1)
    assert position_s(playback) == SECONDS
    assert not playback.is_running
    playback.play(playing=True)
    assert position_s(playback) == 0.0
    clock.advance_ms(1000)
    assert position_s(playback) == 1.0
