"""The figures of a run over a link, from made-up states whose figures are known."""

import numpy as np
import pytest
from msgspec.structs import replace

from common.messages.robot import LoopTiming, Obeyed, SessionState
from lab.measure.wan.figures import (
    Copying,
    Span,
    change_figures,
    following_figures,
    hand_age_figures,
    machine_figures,
    most_within,
    session_figures,
)
from tests.lab.measure.wan.states import CAPTURE_NS, MS, ORIGIN, STATE_NS, played, state, wrist

ROTATION = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
COPYING = Copying(0.5, ROTATION)
SECOND = 50  # states


def tool_at(t_ns: int, lag_ms: int) -> tuple[float, ...]:
    moved = COPYING.scale * ROTATION @ (wrist(t_ns - lag_ms * MS) - wrist(CAPTURE_NS))
    return tuple((np.array(ORIGIN) + moved).tolist())


def test_the_share_followed_begins_with_the_first_engagement_and_counts_time() -> None:
    figures = session_figures(played("D" * 30 + "E" * 75 + "H" * 25))
    assert figures["followed"] == pytest.approx(75 / 99)
    assert figures["holds_a_minute"] == pytest.approx(60 / (99 * 0.02))
    assert (figures["latches"], figures["why"], figures["held_for"]) == (0, "", "ok 1")
    assert figures["age_limit_ms"] == 150.0


def test_time_after_a_latch_is_not_followed_and_the_reason_is_told() -> None:
    figures = session_figures(played("E" * 50 + "H" * 10 + "D" * 41))
    assert figures["followed"] == pytest.approx(0.5)
    assert figures["latches"] == 1
    assert figures["why"] == "disengaged, as played"


def test_where_nothing_engages_the_share_is_zero_and_the_readiness_says_why() -> None:
    assert session_figures(played("D" * 100)) == {"followed": 0.0, "why": "as played"}


def test_changes_count_both_ways_in_the_worst_second() -> None:
    calm, flicker = "E" * 100, "EH" * 5
    assert session_figures(played(calm + "H" + calm))["changes_in_a_second"] == 2
    assert session_figures(played(calm + flicker + calm))["changes_in_a_second"] == 10
    assert session_figures(played("E" * 20 + "D" * 20))["changes_in_a_second"] == 0


def test_the_most_within_a_span_is_found_wherever_it_is() -> None:
    assert most_within([0, 10, 11, 12, 20, 30], 2) == 3
    assert most_within([0, 10, 20], 10) == 2
    assert most_within([], 10) == 0


def test_the_lag_is_found_and_the_error_does_not_contain_it() -> None:
    states = [state(t, tool=tool_at(t, 165)) for t in range(MS, 8_000 * MS, STATE_NS)]
    assert following_figures(states, 2_000 * MS, wrist, COPYING) == {
        "lag_ms": 165.0,
        "error_mm": pytest.approx(0.0, abs=0.01),
    }


def test_what_a_hold_has_lost_is_error_and_does_not_change_the_lag() -> None:
    captured_ns = 4_000 * MS
    lost = np.array([0.0, 0.004, 0.003])  # before the second origin
    begin = tuple((tool_at(captured_ns, 0) + lost).tolist())
    later = [
        state(t, tool=tuple(tool_at(t, 100) + lost), origin=(captured_ns, begin))
        for t in range(4_100 * MS, 5_100 * MS, STATE_NS)
    ]
    figures = following_figures([state(MS), *later], 2_000 * MS, wrist, COPYING)
    assert figures == {"lag_ms": 100.0, "error_mm": pytest.approx(5.0, abs=0.01)}


def test_states_that_hold_do_not_count_for_the_error() -> None:
    follows = [state(t, tool=tool_at(t, 100)) for t in range(MS, 6_000 * MS, STATE_NS)]
    holds = [state(t, SessionState.HOLDING) for t in range(6_000 * MS, 8_000 * MS, STATE_NS)]
    assert following_figures(follows + holds, MS, wrist, COPYING)["error_mm"] == pytest.approx(0.0, abs=0.01)


def test_too_little_following_has_no_error() -> None:
    assert following_figures(played("D" * 50), 0, wrist, COPYING) == {"lag_ms": None, "error_mm": None}
    assert following_figures(played("E" * 20), 0, wrist, COPYING)["error_mm"] is None


def test_the_hands_age_counts_each_obeyed_sample_once_and_none_from_before() -> None:
    def obeyed(seq: int, exposed_ms: int, age_ms: int) -> Obeyed:
        return Obeyed(1, seq, exposed_ms * MS, (exposed_ms + age_ms) * MS, None)

    samples = [obeyed(1, 0, 900)] + [obeyed(k, 100 + k, 10 + k) for k in range(2, 103) for _ in range(k % 3 + 1)]
    states = [state(k * STATE_NS, obeyed=sample) for k, sample in enumerate(samples)]
    figures = hand_age_figures(states, 50 * MS)
    assert figures == {"hand_p50_ms": pytest.approx(62.0), "hand_p99_ms": pytest.approx(111.0)}
    assert hand_age_figures(played("E"), 0) == {"hand_p50_ms": None, "hand_p99_ms": None}


def test_missed_ticks_are_those_of_the_run() -> None:
    first, last = (
        replace(state(0), timing=LoopTiming(250.0, 0.0, missed, ticks, real_time=True))
        for missed, ticks in ((70, 1000), (80, 3000))
    )
    assert machine_figures([first, state(1), last])["ticks_missed"] == pytest.approx(0.005)
    assert machine_figures([first])["ticks_missed"] is None


def test_a_short_cut_holds_and_follows_again() -> None:
    changed, healed = SECOND * STATE_NS, (SECOND + 15) * STATE_NS
    figures = change_figures(played("E" * (SECOND + 6) + "H" * 20 + "E" * 100), Span(changed, healed))
    assert (figures["held"], figures["latched"], figures["holds"], figures["why"]) == (True, False, 1, "")
    assert figures["followed_before"]
    assert figures["followed_after_s"] == pytest.approx(0.2)


def test_a_hold_that_begins_after_healing_counts_as_held_with_the_limit_that_put_it_off() -> None:
    changed, healed = SECOND * STATE_NS, (SECOND + 15) * STATE_NS
    figures = change_figures(played("E" * (SECOND + 17) + "H" * 5 + "E" * 100), Span(changed, healed))
    assert (figures["held"], figures["latched"], figures["age_limit_before_ms"]) == (True, False, 150.0)
    assert not change_figures(played("E" * 200), Span(changed, healed))["held"]


def test_a_hold_soon_after_following_again_defers_it() -> None:
    changed, healed = 0, 15 * STATE_NS
    figures = change_figures(played("E" * 6 + "H" * 14 + "E" * 10 + "H" * 10 + "E" * 50), Span(changed, healed))
    assert figures["followed_after_s"] == pytest.approx((39 - 15) * 0.02)
    assert figures["holds"] == 2


def test_a_long_cut_latches_and_is_ready_without_moving() -> None:
    changed, healed = 0, 50 * STATE_NS
    states = played("E" * 6 + "H" * 20 + "D" * 24)
    states += [state(k * STATE_NS, SessionState.DISENGAGED, ready=k >= 70) for k in range(50, 150)]
    figures = change_figures(states, Span(changed, healed))
    assert (figures["held"], figures["latched"], figures["followed_after_s"]) == (True, True, None)
    assert figures["ready_after_s"] == pytest.approx(0.4)
    assert figures["moved_mrad"] == 0.0


def test_motion_after_healing_and_the_tools_greatest_speed_are_seen() -> None:
    states = [
        state(
            k * STATE_NS, SessionState.DISENGAGED, tool=(0.4 + 0.002 * (k == 7), 0.0, 0.8), q=(0.001 * max(0, k - 5),)
        )
        for k in range(10)
    ]
    figures = change_figures(states, Span(0, 3 * STATE_NS))
    assert figures["moved_mrad"] == pytest.approx(4.0)
    assert (figures["tool_mm_s"], figures["tool_before_mm_s"]) == (pytest.approx(100.0), 0.0)
    assert not figures["followed_before"]
