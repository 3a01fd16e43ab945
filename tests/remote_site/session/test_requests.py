"""Requests: who may do what, and what a robot that is not ready changes."""

import pytest

from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.session.requests import RequestHandler, SessionRequest
from remote_site.session.state_machine import Action
from tests.remote_site.session.session_rig import DEAD, LEASE, READY, engaged

ENGAGE, DISENGAGE = EngagementAction.ENGAGE, EngagementAction.DISENGAGE
STOP, RESET = EngagementAction.STOP, EngagementAction.RESET
HOLDER, OTHER = "anna", "ben"


def ask(rig, action, operator=HOLDER, *, maintenance=False, lease=LEASE, robot=READY):
    """The outcome of one request."""
    request = SessionRequest(action, operator, maintenance)
    return RequestHandler(rig.session).handle(request, lease, robot, rig.now_ns)


@pytest.mark.parametrize("maintenance", [False, True])
@pytest.mark.parametrize("operator", [HOLDER, OTHER])
@pytest.mark.parametrize("lease", [LEASE, None])
def test_anybody_may_stop_the_arm(operator, maintenance, lease):
    rig = engaged()
    outcome = ask(rig, STOP, operator, maintenance=maintenance, lease=lease)
    assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (True, Code.STOPPED, False)
    assert operator in outcome.answer.reason.sentence
    assert rig.frames(40).state is SessionState.DISENGAGED
    assert not rig.session.request_engage(rig.now_ns, READY).done


@pytest.mark.parametrize(
    ("operator", "maintenance", "lease"), [(HOLDER, False, LEASE), (OTHER, True, LEASE), (OTHER, True, None)]
)
def test_holder_and_maintenance_may_reset(operator, maintenance, lease):
    rig = engaged()
    rig.session.stop(OTHER)
    outcome = ask(rig, RESET, operator, maintenance=maintenance, lease=lease)
    assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (True, Code.RESET, False)
    rig.frames(40)
    assert rig.session.request_engage(rig.now_ns, READY).done


def test_the_holder_disengages_and_engages():
    rig = engaged()
    outcome = ask(rig, DISENGAGE)
    assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (True, Code.RELEASED, False)
    assert rig.frames(40).state is SessionState.DISENGAGED
    outcome = ask(rig, ENGAGE)
    assert (outcome.answer.done, outcome.activate) == (True, False)
    assert rig.frames(1).action is Action.CAPTURE


REFUSALS = [
    *[(action, OTHER, False, LEASE, Code.NOT_HOLDER) for action in (ENGAGE, DISENGAGE, RESET)],
    *[(action, HOLDER, False, None, Code.NO_LEASE) for action in (ENGAGE, DISENGAGE, RESET)],
    *[(action, HOLDER, True, LEASE, Code.OPERATORS_ONLY) for action in (ENGAGE, DISENGAGE)],
]


@pytest.mark.parametrize(("action", "operator", "maintenance", "lease", "expected"), REFUSALS)
def test_everybody_else_is_refused_and_changes_nothing(action, operator, maintenance, lease, expected):
    rig, faulty = engaged(), engaged()
    faulty.session.fault("the driver process died")
    for each, state in ((rig, SessionState.ENGAGED), (faulty, SessionState.FAULT)):
        outcome = ask(each, action, operator, maintenance=maintenance, lease=lease, robot=DEAD)
        assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (False, expected, False)
        assert each.session.state is state


def test_an_engagement_clears_a_fault_but_no_stop():
    rig = engaged()
    rig.session.fault("the driver process died")
    rig.frames(1)
    assert ask(rig, ENGAGE).answer.done
    rig.session.stop(OTHER)
    rig.session.fault("the driver process died")
    outcome = ask(rig, ENGAGE)
    assert (outcome.answer.done, outcome.answer.reason.code) == (False, Code.STOPPED)


def test_engaging_a_robot_that_is_not_ready_activates_it_and_has_to_be_asked_again():
    rig = engaged()
    rig.session.fault("brakes on")
    outcome = ask(rig, ENGAGE, robot=DEAD)
    assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (False, Code.ACTIVATED, True)
    assert DEAD.reason in outcome.answer.reason.sentence
    assert rig.frames(40).state is SessionState.DISENGAGED
    assert ask(rig, ENGAGE).answer.done
    assert rig.frames(1).action is Action.CAPTURE


def test_an_engagement_under_a_stop_is_refused_and_activates_nothing():
    rig = engaged()
    rig.session.stop(OTHER)
    outcome = ask(rig, ENGAGE, robot=DEAD)
    assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (False, Code.STOPPED, False)


def test_resetting_a_robot_that_is_not_ready_activates_it_too():
    rig = engaged()
    rig.session.fault("brakes on")
    outcome = ask(rig, RESET, robot=DEAD)
    assert (outcome.answer.done, outcome.activate) == (True, True)
    assert rig.session.state is SessionState.DISENGAGED


@pytest.mark.parametrize("action", [STOP, DISENGAGE])
def test_nothing_else_activates_the_robot(action):
    outcome = ask(engaged(), action, robot=DEAD)
    assert (outcome.answer.done, outcome.activate) == (True, False)
