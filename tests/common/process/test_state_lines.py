"""The lines of a state that comes and goes: one a second with a count, and none of anything else is late."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import FOLLOWING, SessionState
from common.process.state_lines import StateLines

ENGAGED, HOLDING, DISENGAGED = SessionState.ENGAGED, SessionState.HOLDING, SessionState.DISENGAGED


def test_engaged_and_holding_take_one_line_a_second_with_the_count() -> None:
    lines, shown = StateLines(), []
    for k in range(200):  # ten times a second for 2 s, then at rest
        state = (ENGAGED, HOLDING)[k // 5 % 2] if k < 100 else ENGAGED
        if changes := lines.note(state, k * 20 * NS_PER_MS):
            shown.append((k * 20, state, changes))
    assert shown == [(0, ENGAGED, 1), (1000, ENGAGED, 10), (2000, ENGAGED, 10)]


def test_what_begins_or_ends_an_engagement_is_never_late() -> None:
    lines = StateLines()
    told = [
        lines.note(state, k * NS_PER_MS)
        for k, state in enumerate((DISENGAGED, ENGAGED, HOLDING, ENGAGED, DISENGAGED, ENGAGED, SessionState.FAULT))
    ]
    assert told == [1, 1, 0, 0, 3, 1, 1]


@given(st.lists(st.tuples(st.integers(0, 400), st.sampled_from(list(SessionState))), max_size=60))
def test_no_change_is_lost_and_the_last_state_is_shown_within_a_second(steps: list[tuple[int, SessionState]]) -> None:
    lines, now_ns, before, changes, counted, shown = StateLines(), 0, None, 0, 0, []
    for wait_ms, state in steps:
        now_ns += wait_ms * NS_PER_MS
        changes, before = changes + (state is not before), state
        if count := lines.note(state, now_ns):
            counted += count
            shown.append((now_ns, state))
    if before is not None and (count := lines.note(before, now_ns + NS_PER_S)):
        counted += count
        shown.append((now_ns + NS_PER_S, before))
    assert counted == changes
    assert not shown or shown[-1][1] is before or before in FOLLOWING
    for (first_ns, first), (then_ns, then) in pairwise(shown):
        assert then_ns - first_ns >= NS_PER_S or not {first, then} <= set(FOLLOWING)
