"""The fault or stop of a remote site that was started again stays in sight until an operator has answered it."""

import msgspec
import pytest

from common.messages.robot import SITE_ENDED, STOPPED, RobotState, SessionState
from local_site.console.model.history import UnansweredFault
from tests.common.messages.golden_examples import STATE

FAULT, DISENGAGED, ENGAGED = SessionState.FAULT, SessionState.DISENGAGED, SessionState.ENGAGED


def told(session: int, state: SessionState, reason: str = "", code: str = "ok") -> RobotState:
    return msgspec.structs.replace(STATE, session=session, state=state, reason=reason, code=code)


@pytest.mark.parametrize(
    ("states", "reason"),
    [
        ([(1, DISENGAGED)], None),
        ([(1, ENGAGED), (2, DISENGAGED)], None),
        ([(1, FAULT, "joint 2 is blocked")], None),
        ([(1, FAULT, "joint 2 is blocked"), (1, DISENGAGED), (2, DISENGAGED)], None),
        ([(1, FAULT, "joint 2 is blocked"), (2, DISENGAGED)], "joint 2 is blocked"),
        ([(1, FAULT, "joint 2 is blocked"), (2, DISENGAGED), (3, DISENGAGED)], "joint 2 is blocked"),
        ([(1, FAULT, "joint 2 is blocked"), (2, DISENGAGED), (2, ENGAGED)], None),
        ([(1, FAULT, "joint 2 is blocked"), (2, DISENGAGED), (2, ENGAGED), (2, DISENGAGED)], None),
        ([(1, FAULT, "joint 2 is blocked"), (2, FAULT, "no power")], None),
        ([(1, FAULT, "joint 2 is blocked"), (2, FAULT, "no power"), (3, DISENGAGED)], "no power"),
    ],
)
def test_a_fault_is_kept_over_the_restart_of_its_site_until_it_is_answered(
    states: list[tuple[int, SessionState, str]], reason: str | None
) -> None:
    unanswered = UnansweredFault()
    for state in states:
        unanswered.see(told(*state))
    assert unanswered.reason == reason


@pytest.mark.parametrize("last", [[], [(1, DISENGAGED, "asked to end", SITE_ENDED)]])
def test_a_stop_is_kept_over_the_restart_of_its_site_whether_that_ended_in_order_or_not(
    last: list[tuple[int, SessionState, str, str]],
) -> None:
    unanswered, words = UnansweredFault(), "stopped by maintenance"
    for state in (told(1, ENGAGED), told(1, DISENGAGED, words, STOPPED), *(told(*state) for state in last)):
        unanswered.see(state)
        assert unanswered.reason is None
    unanswered.see(told(2, DISENGAGED))
    assert unanswered.reason == words
    unanswered.see(told(2, ENGAGED))
    assert unanswered.reason is None
