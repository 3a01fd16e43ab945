"""Requests: who may do what, and what a robot that is not ready changes."""

import pytest

from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED
from remote_site.reasons import Code
from remote_site.session.config import EngagementMode
from remote_site.session.requests import RequestHandler, SessionRequest
from remote_site.session.state_machine import Action, Robot
from tests.remote_site.session.session_rig import DEAD, LEASE, READY, REST, SessionRig, engaged

ENGAGE, DISENGAGE = EngagementAction.ENGAGE, EngagementAction.DISENGAGE
STOP, RESET = EngagementAction.STOP, EngagementAction.RESET
HOLDER, OTHER = "anna", "ben"


def ask(rig, action, operator=HOLDER, *, maintenance=False, lease=LEASE, robot=READY, seen_ns=None):
    """The outcome of one request, of somebody who was shown the newest halt, or the one at `seen_ns`."""
    shown_ns = rig.session.halts.newest_ns if seen_ns is None else seen_ns
    request = SessionRequest(action, operator, maintenance, shown_ns)
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
    rig.session.stop(OTHER, rig.now_ns)
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
    faulty.session.fault("the driver process died", faulty.now_ns)
    for each, state in ((rig, SessionState.ENGAGED), (faulty, SessionState.FAULT)):
        outcome = ask(each, action, operator, maintenance=maintenance, lease=lease, robot=DEAD)
        assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (False, expected, False)
        assert each.session.state is state


@pytest.mark.parametrize("mode", EngagementMode)
@pytest.mark.parametrize("robot", [READY, DEAD])
def test_an_engagement_clears_no_fault_however_often_it_is_asked_for(mode, robot):
    rig = SessionRig(mode=mode)
    rig.frames(30)
    rig.session.fault("the driver process died", rig.now_ns)
    for _ in range(3):
        outcome = ask(rig, ENGAGE, robot=robot)
        assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (False, Code.FAULT, False)
        assert outcome.answer.reason.sentence == "the driver process died; reset it, then engage"
        assert rig.frames(40, held=True).state is SessionState.FAULT
    assert ask(rig, RESET).answer.done
    assert rig.frames(40, held=True).state is SessionState.DISENGAGED


@pytest.mark.parametrize("fault", [STOPPED, NOT_ACTIVATED, DEAD.fault])
def test_only_a_reset_activates_a_robot_that_takes_no_commands(fault):
    rig, stopped = engaged(), Robot(fault, REST)
    rig.frames(1, stopped)
    outcome = ask(rig, ENGAGE, robot=stopped)
    assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (False, Code.ROBOT_NOT_READY, False)
    assert f"{fault}; reset it" in outcome.answer.reason.sentence
    outcome = ask(rig, RESET, robot=stopped)
    assert (outcome.answer.reason.code, outcome.activate) == (Code.RESET, True)
    assert rig.frames(40).state is SessionState.DISENGAGED
    assert ask(rig, ENGAGE).answer.done
    assert rig.frames(1).action is Action.CAPTURE


def test_an_engagement_under_a_stop_is_refused_and_activates_nothing():
    rig = engaged()
    rig.session.stop(OTHER, rig.now_ns)
    outcome = ask(rig, ENGAGE, robot=DEAD)
    assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (False, Code.STOPPED, False)


def test_resetting_a_robot_that_is_not_ready_activates_it_too():
    rig = engaged()
    rig.session.fault("brakes on", rig.now_ns)
    outcome = ask(rig, RESET, robot=DEAD)
    assert (outcome.answer.done, outcome.activate) == (True, True)
    assert rig.session.state is SessionState.DISENGAGED


@pytest.mark.parametrize("action", [STOP, DISENGAGE])
def test_nothing_else_activates_the_robot(action):
    outcome = ask(engaged(), action, robot=DEAD)
    assert (outcome.answer.done, outcome.activate) == (True, False)
