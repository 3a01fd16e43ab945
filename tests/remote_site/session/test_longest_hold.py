"""A hold ends: whatever trickles in, the engagement is over after the longest hold."""

import pytest

from common.clock import NS_PER_MS
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.safety.config import SafetyConfig
from tests.remote_site.session.session_rig import MOVING, READY, SessionRig, engaged, good

LIMIT_MS = SafetyConfig().longest_hold_ms


def trickle(rig: SessionRig, spacing_ms: float, for_ms: float) -> list[SessionState]:
    """One good sample every `spacing_ms`; the states meanwhile, a tick every 4 ms."""
    states, end_ns = [], rig.now_ns + round(for_ms * NS_PER_MS)
    next_ns = rig.now_ns + round(spacing_ms * NS_PER_MS)
    while rig.now_ns < end_ns:
        rig.now_ns += 4 * NS_PER_MS
        if rig.now_ns >= next_ns:
            rig.session.sample(good(rig.now_ns))
            next_ns += round(spacing_ms * NS_PER_MS)
        states.append(rig.session.tick(rig.now_ns, READY).state)
    return states


@pytest.mark.parametrize("spacing_ms", [150, 250, 400, 480])
def test_samples_that_trickle_in_end_the_engagement_after_the_longest_hold(spacing_ms: float) -> None:
    rig = engaged()
    states = trickle(rig, spacing_ms, 20_000)
    held_ms = 4 * states.count(SessionState.HOLDING)
    assert LIMIT_MS - 4 <= held_ms <= LIMIT_MS + 4
    assert states[-1] is SessionState.DISENGAGED
    rig.frames(90)
    assert rig.session.state is SessionState.DISENGAGED


def test_the_end_of_the_longest_hold_is_explained() -> None:
    rig = engaged()
    trickle(rig, 300, LIMIT_MS + 200)
    answer = rig.session.tick(rig.now_ns, READY).reason
    assert answer.code is Code.LATCHED
    assert f"held for {LIMIT_MS:.0f} ms" in answer.sentence


def test_a_hold_that_ended_does_not_count_for_the_next() -> None:
    rig = engaged()
    for _ in range(5):
        trickle(rig, 300, 0.4 * LIMIT_MS)
        assert rig.session.state is SessionState.HOLDING
        rig.frames(32)
        assert rig.session.state is SessionState.ENGAGED


def test_a_robot_that_never_comes_to_rest_does_not_extend_the_hold() -> None:
    rig = engaged()
    trickle(rig, 300, 400)
    assert rig.frames(round(LIMIT_MS / 33) + 2, MOVING).state is SessionState.DISENGAGED
