"""Holding, ends of an engagement, faults and stops: what ended never starts again by itself."""

import pytest

from common.clock import NS_PER_MS
from common.messages.robot import SessionState
from remote_site.drivers.faults import STOPPED
from remote_site.reasons import Code
from remote_site.safety.config import SafetyConfig
from remote_site.session.age_limit import AgeLimitChoice
from remote_site.session.lease import Holder, Lease
from remote_site.session.state_machine import Action, Robot
from tests.remote_site.session.session_rig import (
    DEAD,
    JUMPS,
    LEASE,
    LOST,
    MOVING,
    NO_OFFSET,
    OLD_OFFSET,
    OTHERS,
    READY,
    REST,
    SessionRig,
    engaged,
    good,
)


def test_age_holds_beyond_soft_and_latches_beyond_latch():
    rig = engaged()
    assert rig.wait(100).action is Action.FOLLOW
    decision = rig.wait(1)
    assert (decision.state, decision.action, decision.reason.code) == (SessionState.HOLDING, Action.STOP, Code.STALE)
    assert rig.wait(399).state is SessionState.HOLDING
    decision = rig.wait(1)
    assert (decision.state, decision.reason.code) == (SessionState.DISENGAGED, Code.LATCHED)
    assert rig.frames(100).state is SessionState.DISENGAGED
    assert rig.session.request_engage(rig.now_ns, READY).done
    assert rig.frames(1).action is Action.CAPTURE


def test_control_that_stood_still_holds_and_catches_nothing_up():
    rig = engaged()
    rig.now_ns += 101 * NS_PER_MS
    rig.session.sample(good(rig.now_ns))
    decision = rig.wait(0)
    assert (decision.state, decision.action, decision.reason.code) == (SessionState.HOLDING, Action.STOP, Code.PAUSED)
    assert decision.reason.sentence == "control paused for 101 ms (limit 100 ms)"
    assert rig.frames(2).state is SessionState.HOLDING
    assert rig.frames(1).action is Action.CAPTURE


def slowly(rig, ticks, robot=READY):
    """Ticks of 60 ms, each with a good sample."""
    for _ in range(ticks):
        rig.now_ns += 60 * NS_PER_MS
        rig.session.sample(good(rig.now_ns))
        decision = rig.session.tick(rig.now_ns, robot)
    return decision


def test_control_that_is_always_late_is_a_fault_of_its_own():
    rig = engaged()
    assert slowly(rig, 16).state is SessionState.ENGAGED
    decision = slowly(rig, 1)
    assert (decision.state, decision.action) == (SessionState.FAULT, Action.STOP)
    assert "control has not kept up for a second: a turn takes 60 ms (limit 50 ms)" in decision.reason.sentence
    assert "or take a faster one; reset it, then engage" in decision.reason.sentence
    rig.session.reset()
    refused = rig.session.request_engage(rig.now_ns, READY)
    assert (refused.done, refused.reason.code) == (False, Code.SLOW)
    rig.frames(30)
    assert rig.session.request_engage(rig.now_ns, READY).done


def test_control_that_is_always_late_engages_nobody_and_is_no_fault_before():
    rig = SessionRig()
    decision = slowly(rig, 100)
    assert (decision.state, decision.reason.code) == (SessionState.DISENGAGED, Code.SLOW)


def test_holding_resumes_with_new_origins_after_fresh_frames_at_rest():
    rig = engaged()
    rig.wait(150)
    assert rig.frames(2).state is SessionState.HOLDING
    decision = rig.frames(1, MOVING)
    assert (decision.state, decision.reason.code) == (SessionState.HOLDING, Code.MOVING)
    assert rig.frames(1).action is Action.CAPTURE
    assert rig.frames(1).action is Action.FOLLOW


def test_a_lost_hand_holds_at_once_and_latches_after_the_latch_time():
    rig = engaged()
    rig.session.sample(LOST)
    decision = rig.wait(4)
    assert (decision.state, decision.reason.code) == (SessionState.HOLDING, Code.LOST)
    for _ in range(20):
        rig.session.sample(LOST)
        decision = rig.wait(33)
    assert decision.state is SessionState.DISENGAGED
    assert "gone" in decision.reason.sentence


@pytest.mark.parametrize(
    "end",
    [
        lambda rig: rig.session.sample(JUMPS),
        lambda rig: rig.session.sample(good(rig.now_ns, new_session=True)),
        lambda rig: rig.session.request_disengage(rig.now_ns),
        lambda rig: (rig.session.authorise(None), rig.session.authorise(LEASE)),
        lambda rig: rig.session.authorise(OTHERS),
        lambda rig: rig.wait(4, DEAD),
        lambda rig: (rig.session.fault("x", rig.now_ns), rig.session.reset()),
    ],
)
def test_every_end_of_an_engagement_needs_an_explicit_engage(end):
    rig = engaged()
    end(rig)
    decision = rig.frames(100)
    assert (decision.state, decision.action) == (SessionState.DISENGAGED, Action.STOP)
    assert rig.session.request_engage(rig.now_ns, READY).done
    assert rig.frames(1).action is Action.CAPTURE


def test_a_fault_stays_until_reset():
    rig = engaged()
    rig.session.fault("the driver process died", rig.now_ns)
    rig.session.request_disengage(rig.now_ns)
    decision = rig.frames(50)
    assert (decision.state, decision.action) == (SessionState.FAULT, Action.STOP)
    assert "driver process" in decision.reason.sentence
    assert not rig.session.request_engage(rig.now_ns, READY).done
    rig.session.reset()
    assert rig.frames(1).state is SessionState.DISENGAGED


def test_a_reset_says_that_it_has_reset_a_fault():
    rig = engaged()
    rig.session.fault("the arm stands still", rig.now_ns)
    answer = rig.session.reset()
    assert (answer.done, answer.reason.code) == (True, Code.RESET)


def test_a_stop_bars_every_engagement_until_it_is_reset():
    rig = engaged()
    assert rig.session.stop("ben", rig.now_ns).done
    decision = rig.frames(100)
    assert (decision.state, decision.action) == (SessionState.DISENGAGED, Action.STOP)
    assert decision.reason.sentence == "stopped by ben; reset it, then engage"
    for barred in (rig.session.request_engage(rig.now_ns, READY), rig.session.readiness(rig.now_ns, READY)):
        assert (barred.done, barred.reason.code) == (False, Code.STOPPED)
    rig.session.reset()
    assert rig.frames(100).state is SessionState.DISENGAGED
    assert rig.session.request_engage(rig.now_ns, READY).done
    assert rig.frames(1).action is Action.CAPTURE


def test_a_stop_outlives_another_stop_and_a_new_session_and_one_reset_ends_it_with_a_fault():
    rig = engaged()
    rig.session.stop("ben", rig.now_ns)
    rig.session.stop("anna", rig.now_ns)
    rig.session.sample(good(rig.now_ns, new_session=True))
    rig.session.fault("the driver process died", rig.now_ns)
    assert rig.frames(50).state is SessionState.FAULT
    assert not rig.session.request_engage(rig.now_ns, READY).done
    assert rig.session.reset().reason.code is Code.RESET
    assert rig.frames(50).state is SessionState.DISENGAGED
    assert rig.session.request_engage(rig.now_ns, READY).done


def test_a_stop_stays_after_a_new_session():
    rig = engaged()
    rig.session.stop("ben", rig.now_ns)
    rig.session.sample(good(rig.now_ns, new_session=True))
    assert rig.frames(50).reason.sentence == "stopped by ben; reset it, then engage"


def test_a_robot_that_stops_by_itself_ends_the_engagement_and_names_the_cure():
    decision = engaged().frames(1, Robot(STOPPED, REST))
    assert (decision.state, decision.action) == (SessionState.DISENGAGED, Action.STOP)
    assert decision.reason.sentence == "the robot is not ready: stopped, not active any more; reset it, then engage"


@pytest.mark.parametrize(("soft", "scale"), [(50.0, 1.0), (100.0, 1.0), (200.0, 0.5), (400.0, 0.25)])
def test_a_longer_soft_limit_slows_the_arm_in_proportion(soft, scale):
    assert AgeLimitChoice(SafetyConfig(t_soft_ms=soft)).limit.speed_scale == scale


def test_after_a_handover_the_reason_names_who_operates_now_and_speaks_of_no_restart():
    rig = engaged()
    rig.session.authorise(Lease(LEASE.number + 1, Holder(8, "ben"), LEASE.expires_ns))
    rig.session.sample(good(rig.now_ns, new_session=True))
    assert rig.wait(4).reason.sentence == "ben (site 8) operates now; engage to continue"


def test_a_lost_lease_latches_and_names_its_holder():
    rig = engaged()
    rig.session.authorise(None)
    decision = rig.wait(4)
    assert (decision.state, decision.action, decision.reason.code) == (
        SessionState.DISENGAGED,
        Action.STOP,
        Code.LATCHED,
    )
    assert "lease of anna (site 7) has ended" in decision.reason.sentence
    rig.session.authorise(LEASE)
    assert rig.frames(60).state is SessionState.DISENGAGED


def test_a_renewed_lease_changes_nothing():
    rig = engaged()
    rig.session.authorise(Lease(41, LEASE.holder, LEASE.expires_ns + 1))
    assert rig.frames(1).action is Action.FOLLOW


@pytest.mark.parametrize("trouble", [NO_OFFSET, OLD_OFFSET])
def test_a_clock_that_is_not_known_any_more_holds_the_arm(trouble):
    rig = engaged()
    rig.session.sample(trouble)
    decision = rig.wait(4)
    assert (decision.state, decision.reason.code) == (SessionState.HOLDING, trouble.reason.code)


def test_while_the_arm_follows_readiness_is_what_it_does_even_in_a_hold():
    rig = engaged()
    rig.wait(150)
    assert rig.session.state is SessionState.HOLDING
    readiness = rig.session.readiness(rig.now_ns, READY)
    assert (readiness.done, readiness.reason.code) == (True, Code.PAUSED)


def test_who_asks_for_what_is_engaged_already_is_told_what_the_arm_does_even_in_a_hold():
    rig = engaged()
    rig.frames(1)
    answer = rig.session.request_engage(rig.now_ns, READY)
    assert (answer.done, answer.reason.code) == (True, Code.OK)
    rig.wait(150)
    answer = rig.session.request_engage(rig.now_ns, READY)
    assert (answer.done, answer.reason.code) == (True, Code.PAUSED)
    rig.session.request_disengage(rig.now_ns)
    assert rig.frames(60).state is SessionState.DISENGAGED
