"""Hold-to-run: the arm follows while a key or pedal is held, and only after a press of its own."""

import pytest

from common.messages.robot import SessionState
from remote_site.reasons import Code, reason
from remote_site.session.config import EngagementMode
from remote_site.session.samples import Rejected
from remote_site.session.state_machine import Action
from tests.remote_site.session.session_rig import (
    DEAD,
    JUMPS,
    LEASE,
    READY,
    SessionRig,
    engaged,
    good,
    held,
)

HELD_DOWN = [(EngagementMode.HOLD_TO_RUN, "key"), (EngagementMode.PEDAL, "pedal")]


@pytest.mark.parametrize("mode", [mode for mode, _ in HELD_DOWN])
def test_during_a_fault_nothing_counts_as_held(mode):
    rig = held(mode)
    rig.session.fault("x", rig.now_ns)
    assert not rig.session.held
    rig.frames(3, held=True)
    assert not rig.session.held


@pytest.mark.parametrize("mode", [mode for mode, _ in HELD_DOWN])
def test_before_the_first_sample_nothing_counts_as_held(mode):
    rig = SessionRig(mode=mode)
    assert not rig.session.held
    assert rig.session.request_engage(rig.now_ns, READY).reason.code is Code.NO_HAND


@pytest.mark.parametrize("mode", [mode for mode, _ in HELD_DOWN])
@pytest.mark.parametrize(
    "bar", [lambda rig: rig.session.stop("ben", rig.now_ns), lambda rig: rig.session.fault("x", rig.now_ns)]
)
def test_an_input_pressed_while_barred_has_to_be_released_after_the_reset(mode, bar):
    rig = held(mode)
    bar(rig)
    rig.frames(40)
    assert rig.frames(40, held=True).state is not SessionState.ENGAGED
    rig.session.reset()
    assert rig.frames(90, held=True).state is SessionState.DISENGAGED
    assert rig.session.request_engage(rig.now_ns, READY).reason.code is Code.LET_GO_FIRST
    rig.frames(1)
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_a_reset_while_the_arm_follows_ends_the_engagement_and_the_holding():
    rig = held()
    rig.session.reset()
    assert rig.frames(90, held=True).state is SessionState.DISENGAGED
    rig.frames(1)
    assert rig.frames(1, held=True).action is Action.CAPTURE


@pytest.mark.parametrize(("mode", "name"), HELD_DOWN)
def test_the_arm_follows_while_the_input_is_held_and_stops_when_it_is_let_go(mode, name):
    rig = held(mode)
    assert rig.frames(20, held=True).action is Action.FOLLOW
    decision = rig.frames(1)
    assert (decision.state, decision.action, decision.reason.code) == (
        SessionState.DISENGAGED,
        Action.STOP,
        Code.LET_GO,
    )
    assert name in decision.reason.sentence
    assert rig.frames(50).state is SessionState.DISENGAGED
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_letting_go_for_a_single_sample_takes_new_origins():
    rig = held()
    assert rig.frames(1).state is SessionState.DISENGAGED
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_an_input_held_before_all_is_ready_counts_when_it_is():
    rig = SessionRig(mode=EngagementMode.HOLD_TO_RUN)
    rig.frames(1)
    assert rig.frames(28, held=True).state is SessionState.DISENGAGED
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_an_input_that_was_never_seen_let_go_engages_nothing():
    rig = SessionRig(mode=EngagementMode.HOLD_TO_RUN)
    assert rig.frames(90, held=True).state is SessionState.DISENGAGED
    answer = rig.session.request_engage(rig.now_ns, READY)
    assert (answer.done, answer.reason.code) == (False, Code.LET_GO_FIRST)
    rig.frames(1)
    assert rig.session.request_engage(rig.now_ns, READY).reason.code is Code.NOT_HELD


@pytest.mark.parametrize(
    "end",
    [
        lambda rig: rig.wait(501),
        lambda rig: rig.session.sample(JUMPS),
        lambda rig: (rig.session.authorise(None), rig.session.authorise(LEASE)),
        lambda rig: rig.session.sample(good(rig.now_ns, new_session=True, held=True)),
        lambda rig: rig.wait(4, DEAD),
        lambda rig: (rig.session.fault("x", rig.now_ns), rig.session.reset()),
        lambda rig: rig.session.request_disengage(rig.now_ns),
    ],
)
def test_an_input_still_held_after_the_end_of_an_engagement_has_to_be_pressed_anew(end):
    rig = held()
    end(rig)
    assert rig.frames(90, held=True).state is not SessionState.ENGAGED
    rig.frames(1)
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_an_input_held_while_the_hand_was_away_has_to_be_pressed_anew():
    rig = SessionRig(mode=EngagementMode.HOLD_TO_RUN)
    rig.frames(5)
    rig.frames(5, held=True)
    rig.wait(600)
    assert rig.frames(90, held=True).state is SessionState.DISENGAGED


def test_letting_go_counts_even_in_a_sample_whose_hand_is_lost():
    rig = held()
    lost = good(rig.now_ns).sample
    rig.session.sample(Rejected(reason(Code.LOST, reason="gone"), hand_lost=True, sample=lost))
    assert rig.wait(4).reason.code is Code.LET_GO


@pytest.mark.parametrize("barred", [False, True])
def test_a_silent_page_is_no_sight_of_a_key_let_go(barred):
    rig = held()
    if barred:
        rig.session.stop("ben", rig.now_ns)
        rig.session.reset()
    assert rig.unreported().state is SessionState.DISENGAGED
    assert rig.frames(40, held=True).state is SessionState.DISENGAGED
    rig.frames(1)
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_the_key_means_nothing_where_engagement_is_automatic():
    rig = engaged()
    rig.frames(5, held=True)
    assert rig.frames(5).action is Action.FOLLOW


def test_readiness_is_told_apart_from_what_the_operator_wants():
    rig = SessionRig(mode=EngagementMode.HOLD_TO_RUN)
    rig.frames(10)
    assert rig.session.readiness(rig.now_ns, READY).reason.code is Code.COLLECTING
    rig.frames(20)
    assert rig.session.readiness(rig.now_ns, READY).reason.code is Code.READY
    assert not rig.session.held
    rig.frames(1, held=True)
    assert rig.session.held
    rig.session.fault("x", rig.now_ns)
    answer = rig.session.readiness(rig.now_ns, READY)
    assert (answer.done, answer.reason.code) == (False, Code.FAULT)
