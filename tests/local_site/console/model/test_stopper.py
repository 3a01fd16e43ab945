"""Whose stop stands: that of the page that asked for it, as long as it is not reset."""

import msgspec
import pytest

from common.clock import NS_PER_S
from common.messages.robot import STOPPED, Readiness, RobotState, SessionState
from local_site.console.model.history import ASKED_WITHIN_NS, Stopper
from local_site.console.model.seat import Visitor
from tests.common.messages.golden_examples import STATE

HERE, THERE = Visitor(1, "127.0.0.1"), Visitor(2, "10.0.0.7")


def told(code: str, state: SessionState = SessionState.DISENGAGED) -> RobotState:
    return msgspec.structs.replace(STATE, state=state, readiness=Readiness(False, code, "", False))


STANDING, RESET, FAULT = told(STOPPED), told("not_engaged"), told("fault", SessionState.FAULT)


@pytest.mark.parametrize("halted", [STANDING, FAULT])
def test_the_stop_that_stands_is_of_the_page_that_has_asked_for_it(halted: RobotState) -> None:
    stopper = Stopper()
    stopper.see(RESET, 0)
    stopper.ask(HERE, 0)
    stopper.see(RESET, 1)  # not there yet
    assert stopper.page is None
    stopper.see(halted, 2)
    stopper.see(halted, 100 * NS_PER_S)
    assert stopper.page == HERE
    stopper.ask(THERE, 101 * NS_PER_S)
    stopper.see(halted, 101 * NS_PER_S)
    assert stopper.page == THERE


def test_a_later_stop_of_somebody_else_is_no_longer_this_pages() -> None:
    stopper = Stopper()
    stopper.ask(HERE, 0)
    stopper.see(STANDING, 1)
    stopper.see(RESET, NS_PER_S)
    assert stopper.page is None
    stopper.see(STANDING, ASKED_WITHIN_NS + 1)
    assert stopper.page is None
