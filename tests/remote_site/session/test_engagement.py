"""Engagement has to be earned: good samples in a row, everything ready, and a request where one is needed."""

from dataclasses import replace

import pytest
from msgspec import structs

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import SessionState
from remote_site.reasons import Code, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.age_limit import AgeLimitChoice
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.hand_signal import AGAIN_FRAMES
from remote_site.session.samples import Rejected
from remote_site.session.state_machine import Action, Session
from tests.present import present
from tests.remote_site.remote_loop import hand
from tests.remote_site.session.session_rig import (
    DEAD,
    JUMPS,
    LEASE,
    LOST,
    MOVING,
    NO_OFFSET,
    OLD_OFFSET,
    OTHERS,
    PERIOD,
    READY,
    SessionRig,
    good,
)


def unanswered(rig: SessionRig, count: int, since_ns: int) -> Code:
    """The reason after so many good samples whose clocks were compared last at this time, as by lanes alone."""
    for _ in range(count):
        rig.now_ns += PERIOD
        sample = good(rig.now_ns)
        clock = structs.replace(present(sample.sample.clock), measured_ns=since_ns)
        rig.session.sample(replace(sample, sample=structs.replace(sample.sample, clock=clock)))
        decision = rig.session.tick(rig.now_ns, READY)
    return decision.reason.code


def test_nothing_engages_while_the_senders_questions_are_not_answered_for_a_second_and_a_half():
    rig = SessionRig()
    since_ns = rig.now_ns - 600 * NS_PER_MS
    assert unanswered(rig, 20, since_ns) is Code.COLLECTING
    assert unanswered(rig, 40, since_ns) is Code.OLD_OFFSET
    assert rig.session.state is SessionState.DISENGAGED
    assert rig.frames(1).action is Action.CAPTURE


def test_an_arm_that_follows_goes_on_following_while_questions_are_not_answered():
    rig = SessionRig()
    rig.frames(30)
    unanswered(rig, 60, rig.now_ns)
    assert rig.session.state is SessionState.ENGAGED


def test_thirty_good_frames_engage_once_and_capture():
    rig = SessionRig()
    decision = rig.frames(29)
    assert (decision.state, decision.action) == (SessionState.DISENGAGED, Action.STOP)
    assert decision.reason.code is Code.COLLECTING
    decision = rig.frames(1)
    assert (decision.state, decision.action) == (SessionState.ENGAGED, Action.CAPTURE)
    assert rig.frames(1).action is Action.FOLLOW


def test_manual_engagement_waits_to_be_asked():
    rig = SessionRig(mode=EngagementMode.ON_REQUEST)
    assert rig.frames(60).state is SessionState.DISENGAGED
    assert rig.session.request_engage(rig.now_ns, READY).done
    assert rig.wait(4).action is Action.CAPTURE


def test_engagements_are_counted_one_by_one():
    rig = SessionRig(mode=EngagementMode.ON_REQUEST)
    counts = []
    for _ in range(3):
        rig.frames(40)
        rig.session.request_engage(rig.now_ns, READY)
        rig.frames(5)
        counts.append(rig.session.engagements)
        rig.session.request_disengage(rig.now_ns)
    assert counts == [1, 2, 3]


@pytest.mark.parametrize(
    ("period_ms", "age_ms", "expected"), [(140, 60, Code.SAMPLES_RARE), (33, 420, Code.LINK_TOO_SLOW)]
)
def test_neither_rare_samples_nor_a_slow_link_can_be_engaged_with(period_ms, age_ms, expected):
    safety, now_ns = SafetyConfig(), 10 * NS_PER_S
    choice = AgeLimitChoice(safety)
    session = Session(safety, EngagementConfig(), choice.limit)
    session.authorise(LEASE)
    for seq in range(40):
        now_ns += period_ms * NS_PER_MS
        choice.see(hand(seq, now_ns), now_ns, now_ns + age_ms * NS_PER_MS)
        session.limit_age(choice.settle(0.0))
    session.sample(good(now_ns))
    assert session.readiness(now_ns, READY).reason.code is expected


def test_good_samples_before_the_first_tick_engage_nothing_unasked():
    rig = SessionRig(mode=EngagementMode.ON_REQUEST)
    for _ in range(40):
        rig.now_ns += PERIOD
        rig.session.sample(good(rig.now_ns))
    decision = rig.wait(4)
    assert (decision.state, decision.action) == (SessionState.DISENGAGED, Action.STOP)


@pytest.mark.parametrize(
    ("prepare", "robot", "expected"),
    [
        (lambda rig: rig.wait(4), READY, Code.NO_HAND),
        (lambda rig: rig.frames(12), READY, Code.COLLECTING),
        (lambda rig: rig.frames(30, DEAD), DEAD, Code.ROBOT_NOT_READY),
        (lambda rig: rig.frames(30, MOVING), MOVING, Code.MOVING),
        (lambda rig: (rig.frames(40), rig.wait(101)), READY, Code.STALE),
        (lambda rig: (rig.frames(40), rig.session.sample(LOST)), READY, Code.LOST),
        (lambda rig: rig.session.fault("driver died", rig.now_ns), READY, Code.FAULT),
        (lambda rig: (rig.frames(40), rig.session.authorise(None)), READY, Code.NO_LEASE),
        (lambda rig: (rig.frames(40), rig.session.sample(NO_OFFSET)), READY, Code.NO_OFFSET),
        (lambda rig: (rig.frames(40), rig.session.sample(OLD_OFFSET)), READY, Code.OLD_OFFSET),
    ],
)
def test_engaging_is_refused_with_the_reason(prepare, robot, expected):
    rig = SessionRig(mode=EngagementMode.ON_REQUEST)
    prepare(rig)
    answer = rig.session.request_engage(rig.now_ns, robot)
    assert not answer.done
    assert answer.reason.code is expected
    assert rig.wait(0, robot).state is not SessionState.ENGAGED


def test_a_gap_between_good_frames_counts_them_anew():
    rig = SessionRig()
    rig.frames(29)
    rig.wait(101)
    assert rig.frames(29).state is SessionState.DISENGAGED
    assert rig.frames(1).state is SessionState.ENGAGED


def test_a_lost_frame_counts_anew_but_a_duplicate_does_not():
    rig = SessionRig()
    rig.frames(20)
    rig.session.sample(Rejected(reason(Code.DUPLICATE, seq=3)))
    assert rig.frames(10).state is SessionState.ENGAGED
    rig = SessionRig()
    rig.frames(20)
    rig.session.sample(LOST)
    assert rig.frames(29).state is SessionState.DISENGAGED


def test_a_new_session_before_the_first_engagement_disarms_the_automatic_one():
    rig = SessionRig()
    rig.frames(10)
    rig.session.sample(good(rig.now_ns, new_session=True))
    assert rig.frames(100).state is SessionState.DISENGAGED


def test_disengaging_before_the_first_engagement_disarms_the_automatic_one():
    rig = SessionRig()
    rig.frames(10)
    rig.session.request_disengage(rig.now_ns)
    assert rig.frames(100).state is SessionState.DISENGAGED


def test_jumps_before_the_first_engagement_only_count_anew():
    rig = SessionRig()
    rig.frames(10)
    rig.session.sample(JUMPS)
    assert rig.frames(29).state is SessionState.DISENGAGED
    assert rig.frames(1).state is SessionState.ENGAGED


def test_what_one_operator_has_shown_does_not_count_for_the_next():
    rig = SessionRig(mode=EngagementMode.ON_REQUEST)
    rig.frames(40)
    rig.session.authorise(OTHERS)
    answer = rig.session.request_engage(rig.now_ns, READY)
    assert (answer.done, answer.reason.code) == (False, Code.NO_HAND)


@pytest.mark.parametrize(("lease", "needed"), [(replace(LEASE, number=43), AGAIN_FRAMES), (OTHERS, 30)])
def test_after_a_cut_that_cost_the_lease_its_holder_needs_fewer_frames_and_another_all(lease, needed):
    rig = SessionRig(mode=EngagementMode.ON_REQUEST)
    rig.frames(30)
    rig.session.authorise(None)
    rig.now_ns += 10 * NS_PER_S
    rig.session.authorise(lease)
    rig.frames(needed - 1)
    missing = rig.session.readiness(rig.now_ns, READY).reason
    assert missing == reason(Code.COLLECTING, count=needed - 1, needed=needed)
    rig.frames(1)
    assert rig.session.readiness(rig.now_ns, READY).done
