"""The session machine: engagement has to be earned, and what ended never starts again by itself."""

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from remote_loop import hand

from common.clock import NS_PER_MS
from common.messages import SessionState
from remote_site.config import EngagementConfig, EngagementMode, SafetyConfig
from remote_site.intake import Accepted, Rejected
from remote_site.lease import Holder, Lease
from remote_site.safety.state import FOLLOWING, Action, Robot, Session
from remote_site.safety.status import Code, reason

READY = Robot(ready=True, reason="", resting=True)
MOVING = Robot(ready=True, reason="", resting=False)
DEAD = Robot(ready=False, reason="brakes on", resting=True)
LEASE = Lease(41, Holder(7, "anna"), 10**18)
PERIOD = 33 * NS_PER_MS
LOST = Rejected(reason(Code.LOST, reason="gone"), hand_lost=True)
JUMPS = Rejected(reason(Code.JUMPS, count=3), latch=True)


def good(born_ns, new_session=False):
    return Accepted(hand(1, born_ns), np.zeros(3), None, born_ns, new_session)


class Rig:
    """A session and its clock."""

    def __init__(self, **engagement):
        self.session = Session(SafetyConfig(), EngagementConfig(**engagement))
        self.session.authorise(LEASE)
        self.now_ns = 10_000 * NS_PER_MS

    def frames(self, count, robot=READY):
        """So many good samples at the camera's pace, each followed by a tick."""
        for _ in range(count):
            self.now_ns += PERIOD
            self.session.sample(good(self.now_ns))
            decision = self.session.tick(self.now_ns, robot)
        return decision

    def wait(self, milliseconds, robot=READY):
        self.now_ns += round(milliseconds * NS_PER_MS)
        return self.session.tick(self.now_ns, robot)


def engaged(**engagement):
    rig = Rig(**engagement)
    rig.frames(30)
    assert rig.session.state is SessionState.ENGAGED
    return rig


def test_thirty_good_frames_engage_once_and_capture():
    rig = Rig()
    decision = rig.frames(29)
    assert (decision.state, decision.action) == (SessionState.DISENGAGED, Action.STOP)
    assert decision.reason.code is Code.COLLECTING
    decision = rig.frames(1)
    assert (decision.state, decision.action) == (SessionState.ENGAGED, Action.CAPTURE)
    assert rig.frames(1).action is Action.FOLLOW


def test_manual_engagement_waits_to_be_asked():
    rig = Rig(mode=EngagementMode.ON_REQUEST)
    assert rig.frames(60).state is SessionState.DISENGAGED
    assert rig.session.request_engage(rig.now_ns, READY).done
    assert rig.wait(4).action is Action.CAPTURE


@pytest.mark.parametrize(
    ("prepare", "robot", "expected"),
    [
        (lambda rig: rig.wait(4), READY, Code.NO_HAND),
        (lambda rig: rig.frames(12), READY, Code.COLLECTING),
        (lambda rig: rig.frames(30, DEAD), DEAD, Code.ROBOT_NOT_READY),
        (lambda rig: rig.frames(30, MOVING), MOVING, Code.MOVING),
        (lambda rig: (rig.frames(40), rig.wait(101)), READY, Code.STALE),
        (lambda rig: (rig.frames(40), rig.session.sample(LOST)), READY, Code.LOST),
        (lambda rig: rig.session.fault("driver died"), READY, Code.FAULT),
    ],
)
def test_engaging_is_refused_with_the_reason(prepare, robot, expected):
    rig = Rig(mode=EngagementMode.ON_REQUEST)
    prepare(rig)
    answer = rig.session.request_engage(rig.now_ns, robot)
    assert not answer.done
    assert answer.reason.code is expected
    assert rig.wait(0, robot).state is not SessionState.ENGAGED


def test_a_gap_between_good_frames_counts_them_anew():
    rig = Rig()
    rig.frames(29)
    rig.wait(101)
    assert rig.frames(29).state is SessionState.DISENGAGED
    assert rig.frames(1).state is SessionState.ENGAGED


def test_a_lost_frame_counts_anew_but_a_duplicate_does_not():
    rig = Rig()
    rig.frames(20)
    rig.session.sample(Rejected(reason(Code.DUPLICATE, seq=3)))
    assert rig.frames(10).state is SessionState.ENGAGED
    rig = Rig()
    rig.frames(20)
    rig.session.sample(LOST)
    assert rig.frames(29).state is SessionState.DISENGAGED


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
        lambda rig: rig.session.request_disengage(),
        lambda rig: rig.wait(4, DEAD),
        lambda rig: (rig.session.fault("x"), rig.session.reset()),
    ],
)
def test_every_end_of_an_engagement_needs_an_explicit_engage(end):
    rig = engaged()
    end(rig)
    decision = rig.frames(100)
    assert (decision.state, decision.action) == (SessionState.DISENGAGED, Action.STOP)
    assert rig.session.request_engage(rig.now_ns, READY).done
    assert rig.frames(1).action is Action.CAPTURE


def test_a_new_session_before_the_first_engagement_disarms_the_automatic_one():
    rig = Rig()
    rig.frames(10)
    rig.session.sample(good(rig.now_ns, new_session=True))
    assert rig.frames(100).state is SessionState.DISENGAGED


def test_disengaging_before_the_first_engagement_disarms_the_automatic_one():
    rig = Rig()
    rig.frames(10)
    rig.session.request_disengage()
    assert rig.frames(100).state is SessionState.DISENGAGED


def test_jumps_before_the_first_engagement_only_count_anew():
    rig = Rig()
    rig.frames(10)
    rig.session.sample(JUMPS)
    assert rig.frames(29).state is SessionState.DISENGAGED
    assert rig.frames(1).state is SessionState.ENGAGED


def test_a_fault_stays_until_reset():
    rig = engaged()
    rig.session.fault("the driver process died")
    rig.session.request_disengage()
    decision = rig.frames(50)
    assert (decision.state, decision.action) == (SessionState.FAULT, Action.STOP)
    assert "driver process" in decision.reason.sentence
    assert not rig.session.request_engage(rig.now_ns, READY).done
    rig.session.reset()
    assert rig.frames(1).state is SessionState.DISENGAGED


@pytest.mark.parametrize(("soft", "scale"), [(50.0, 1.0), (100.0, 1.0), (200.0, 0.5), (400.0, 0.25)])
def test_a_longer_soft_limit_slows_the_arm_in_proportion(soft, scale):
    assert Session(SafetyConfig(t_soft_ms=soft), EngagementConfig()).speed_scale == scale


class SessionMachine(RuleBasedStateMachine):
    """Arbitrary events; the arm follows only on fresh samples of an engagement that was granted."""

    def __init__(self):
        super().__init__()
        self.session = Session(SafetyConfig(), EngagementConfig(frames=3))
        self.session.authorise(LEASE)
        self.now_ns, self.born_ns = 10_000 * NS_PER_MS, None
        self.granted, self.captured = True, False
        self.decision = None

    @rule(count=st.integers(1, 6), new=st.booleans())
    def see(self, count, new):
        for k in range(count):
            self.now_ns += PERIOD
            first_new = new and k == 0
            self.session.sample(good(self.now_ns, first_new))
            self.born_ns = self.now_ns
            if first_new:
                self.end()
            self.step(READY)

    @rule(ticks=st.integers(1, 40), robot=st.sampled_from([READY, READY, MOVING, DEAD]))
    def pass_time(self, ticks, robot):
        for _ in range(ticks):
            self.now_ns += 16 * NS_PER_MS
            self.step(robot)

    @rule(what=st.sampled_from([LOST, JUMPS]))
    def trouble(self, what):
        followed = self.session.state in FOLLOWING
        self.session.sample(what)
        if followed and what is JUMPS:
            self.end()

    @rule()
    def engage(self):
        self.granted |= self.session.request_engage(self.now_ns, READY).done

    @rule()
    def disengage(self):
        self.session.request_disengage()
        self.end()

    @rule()
    def fail(self):
        self.session.fault("x")
        self.end()

    @rule()
    def reset(self):
        self.session.reset()

    def end(self):
        self.granted = self.captured = False

    def step(self, robot):
        self.decision = self.session.tick(self.now_ns, robot)
        if self.decision.action is Action.CAPTURE:
            assert self.granted
            assert robot is READY
            self.captured = True
        if self.decision.action is Action.FOLLOW:
            assert self.captured
        if self.decision.action is not Action.STOP:
            assert self.decision.state is SessionState.ENGAGED
            assert self.now_ns - self.born_ns <= 100 * NS_PER_MS
            assert robot is not DEAD
        if self.decision.state is not SessionState.ENGAGED:
            self.captured = False
        if self.decision.state not in FOLLOWING and self.session.engagements:
            self.granted = False

    @invariant()
    def a_reason_is_always_given(self):
        if self.decision is not None:
            assert self.decision.reason.sentence


TestSessionMachine = SessionMachine.TestCase
TestSessionMachine.settings = settings(max_examples=60, stateful_step_count=30, deadline=None, derandomize=True)
