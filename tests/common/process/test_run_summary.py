"""What a site says of its run at its end: times, holds with their reasons, stops, and the worst while engaged."""

import msgspec
import pytest

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import STOPPED, LoopTiming, SessionState
from common.process.run_summary import MOST_CODES, OTHER, RunSummary, in_words
from remote_site.reasons import Code
from tests.present import present

EVERY_NS = 20 * NS_PER_MS
DISENGAGED, ENGAGED, HOLDING, FAULT = (
    SessionState.DISENGAGED,
    SessionState.ENGAGED,
    SessionState.HOLDING,
    SessionState.FAULT,
)


def state(word, code="ok", age_ms=30.0, late_us=100.0, missed=0):
    link = msgspec.structs.replace(present(golden.STATE.hand_link), age_ms=age_ms)
    timing = LoopTiming(hz=250.0, late_p99_us=late_us, missed=missed, ticks=5000, real_time=True)
    return msgspec.structs.replace(golden.STATE, state=word, code=code, hand_link=link, timing=timing)


def summary_of(*stretches):
    """Of stretches of a state (None: unknown) and its seconds, published each 20 ms."""
    summary, now_ns = RunSummary(), 7
    for given, seconds in stretches:
        for _ in range(round(seconds * NS_PER_S / EVERY_NS)):
            summary.note(given, now_ns)
            now_ns += EVERY_NS
    return summary


def test_engagements_and_holds_are_counted_with_their_times_and_most_frequent_reasons():
    following, late, lost = state(ENGAGED), state(HOLDING, "stale"), state(HOLDING, "lost")
    summary = summary_of(
        (state(DISENGAGED), 2),
        (following, 3),
        (late, 0.5),
        (following, 1),
        (late, 0.5),
        (following, 1),
        (lost, 1),
        (state(DISENGAGED, "latched"), 1),
        (following, 2),
        (state(DISENGAGED, "released"), 0.1),
    )
    assert (summary.engagements, summary.engaged_ns) == (2, 9 * NS_PER_S)
    assert (summary.holds, summary.held_ns) == ({"stale": 2, "lost": 1}, 2 * NS_PER_S)
    said = summary.sentences()
    assert said["run"] == "12.1 s, engaged 2 times for 9.0 s"
    assert said["held"] == "3 times for 2.0 s (2 stale, 1 lost); stops: 0, faults: 0"


def test_a_hold_whose_reason_changes_is_one_hold_by_its_first_reason():
    summary = summary_of((state(ENGAGED), 1), (state(HOLDING, "stale"), 1), (state(HOLDING, "lost"), 1))
    assert summary.holds == {"stale": 1}


def test_what_an_unheard_site_does_meanwhile_is_not_counted():
    """A silent remote site, or one that obeys another operator; and a gap between states that is no silence yet."""
    heard = summary_of((state(ENGAGED), 1), (None, 60), (state(ENGAGED), 1), (None, 0.1))
    assert (heard.engagements, heard.engaged_ns) == (2, 2 * NS_PER_S)
    gap = RunSummary()
    gap.note(state(ENGAGED), 0)
    gap.note(state(ENGAGED), 30 * NS_PER_S)
    assert gap.engaged_ns == 0
    assert gap.sentences()["run"].startswith("30.0 s, engaged once")


def test_a_stop_is_counted_once_however_long_it_stays_and_again_after_a_reset():
    stopped = state(DISENGAGED, STOPPED)
    summary = summary_of((stopped, 2), (None, 1), (stopped, 2), (state(DISENGAGED, "reset"), 1), (stopped, 1))
    assert summary.stops == 2
    assert summary.sentences()["held"] == "never; stops: 2, faults: 0"
    assert Code.STOPPED.value == STOPPED


def test_a_fault_is_counted_when_it_comes():
    fault = state(FAULT, "fault")
    assert summary_of((state(ENGAGED), 1), (fault, 3), (state(DISENGAGED), 1), (fault, 1)).faults == 2


def test_the_worst_is_that_of_the_engagements_alone():
    start, worst = state(DISENGAGED, age_ms=900.0, late_us=9000.0), state(ENGAGED, age_ms=310.0, late_us=1800.0)
    summary = summary_of((start, 1), (worst, 0.1), (state(ENGAGED, missed=3), 1), (state(DISENGAGED, missed=4), 1))
    said = summary.sentences()["worst"]
    assert said == "hand age 310 ms, control 1.8 ms late (p99), 4 of 5000 ticks missed"


def test_a_run_without_an_engagement_says_so_in_one_line():
    assert summary_of((state(DISENGAGED), 1)).sentences() == {"run": "1.0 s, never engaged"}
    assert RunSummary().sentences() == {"run": "0.0 s, never engaged"}


def test_ever_new_reasons_take_no_more_memory():
    summary = RunSummary()
    for k in range(500):
        summary.note(state(ENGAGED), 2 * k)
        summary.note(state(HOLDING, f"code{k}"), 2 * k + 1)
    assert len(summary.holds) == MOST_CODES + 1
    assert summary.holds[OTHER] == 500 - MOST_CODES
    assert summary.sentences()["held"].count(",") < 6


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.04, "0.0 s"), (59.4, "59.4 s"), (60, "1 min 0 s"), (725, "12 min 5 s"), (11_100, "3 h 5 min")],
)
def test_durations_are_said_as_people_do(seconds, words):
    assert in_words(round(seconds * NS_PER_S)) == words
