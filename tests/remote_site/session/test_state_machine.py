"""The session machine: engagement has to be earned, and what ended never starts again by itself."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from common.clock import NS_PER_MS
from common.messages.hand import Intent
from common.messages.robot import SessionState
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.lease import Holder, Lease
from remote_site.session.samples import Accepted, Rejected
from remote_site.session.state_machine import (
    FOLLOWING,
    Action,
    Robot,
    Session,
)
from tests.remote_site.remote_loop import hand

REST = JointMotion.at_rest(np.zeros(6))
READY = Robot(None, REST)
MOVING = Robot(None, replace(REST, dq=np.ones(6)))
DEAD = Robot(RobotFault(FaultCode.ROBOT, "brakes on"), REST)
LEASE = Lease(41, Holder(7, "anna"), 10**18)
OTHERS = Lease(42, Holder(8, "ben"), 10**18)
PERIOD = 33 * NS_PER_MS
LOST = Rejected(reason(Code.LOST, reason="gone"), hand_lost=True)
NO_OFFSET = Rejected(reason(Code.NO_OFFSET))
OLD_OFFSET = Rejected(reason(Code.OLD_OFFSET, age_ms=5001, limit_ms=5000))
JUMPS = Rejected(reason(Code.JUMPS, count=3), latch=True)


def good(born_ns, new_session=False, held=False):
    return Accepted(hand(1, born_ns, intent=Intent(hold=held)), np.zeros(3), None, born_ns, new_session)


class Rig:
    """A session and its clock."""

    def __init__(self, **engagement):
        self.session = Session(SafetyConfig(), EngagementConfig(**engagement))
        self.session.authorise(LEASE)
        self.now_ns = 10_000 * NS_PER_MS

    def frames(self, count, robot=READY, held=False):
        """This many good samples at the camera's rate, each followed by a tick."""
        for _ in range(count):
            self.now_ns += PERIOD
            self.session.sample(good(self.now_ns, held=held))
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
        (lambda rig: (rig.frames(40), rig.session.authorise(None)), READY, Code.NO_LEASE),
        (lambda rig: (rig.frames(40), rig.session.sample(NO_OFFSET)), READY, Code.NO_OFFSET),
        (lambda rig: (rig.frames(40), rig.session.sample(OLD_OFFSET)), READY, Code.OLD_OFFSET),
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


def test_control_that_stood_still_holds_and_catches_nothing_up():
    rig = engaged()
    rig.now_ns += 101 * NS_PER_MS
    rig.session.sample(good(rig.now_ns))
    decision = rig.wait(0)
    assert (decision.state, decision.action, decision.reason.code) == (SessionState.HOLDING, Action.STOP, Code.PAUSED)
    assert rig.frames(2).state is SessionState.HOLDING
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
        lambda rig: (rig.session.authorise(None), rig.session.authorise(LEASE)),
        lambda rig: rig.session.authorise(OTHERS),
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


def test_a_stop_bars_every_engagement_until_it_is_reset():
    rig = engaged()
    assert rig.session.stop("ben").done
    decision = rig.frames(100)
    assert (decision.state, decision.action) == (SessionState.DISENGAGED, Action.STOP)
    assert decision.reason.sentence == "stopped by ben; reset it, then engage"
    for barred in (rig.session.request_engage(rig.now_ns, READY), rig.session.readiness(rig.now_ns, READY)):
        assert (barred.done, barred.reason.code) == (False, Code.STOPPED)
    rig.session.reset()
    assert rig.frames(100).state is SessionState.DISENGAGED
    assert rig.session.request_engage(rig.now_ns, READY).done
    assert rig.frames(1).action is Action.CAPTURE


def test_a_stop_outlives_another_stop_a_new_session_and_a_fault():
    rig = engaged()
    rig.session.stop("ben")
    rig.session.stop("anna")
    rig.session.sample(good(rig.now_ns, new_session=True))
    rig.session.fault("the driver process died")
    assert rig.frames(50).state is SessionState.FAULT
    rig.session.clear_fault()
    assert rig.frames(50).reason.sentence == "stopped by ben; reset it, then engage"
    assert not rig.session.request_engage(rig.now_ns, READY).done
    assert rig.session.reset().reason.code is Code.RESET


def test_a_key_pressed_anew_does_not_engage_while_stopped():
    rig = held()
    rig.session.stop("ben")
    rig.frames(40)
    assert rig.frames(40, held=True).state is SessionState.DISENGAGED
    rig.session.reset()
    assert rig.frames(1, held=True).action is Action.CAPTURE


@pytest.mark.parametrize(("soft", "scale"), [(50.0, 1.0), (100.0, 1.0), (200.0, 0.5), (400.0, 0.25)])
def test_a_longer_soft_limit_slows_the_arm_in_proportion(soft, scale):
    assert SafetyConfig(t_soft_ms=soft).speed_scale == scale


def test_a_lost_lease_latches_and_names_its_holder():
    rig = engaged()
    rig.session.authorise(None)
    decision = rig.wait(4)
    assert (decision.state, decision.action, decision.reason.code) == (
        SessionState.DISENGAGED,
        Action.STOP,
        Code.LATCHED,
    )
    assert "lease of anna has ended" in decision.reason.sentence
    rig.session.authorise(LEASE)
    assert rig.frames(60).state is SessionState.DISENGAGED


def test_a_renewed_lease_changes_nothing():
    rig = engaged()
    rig.session.authorise(Lease(41, LEASE.holder, LEASE.expires_ns + 1))
    assert rig.frames(1).action is Action.FOLLOW


def test_what_one_operator_has_shown_does_not_count_for_the_next():
    rig = Rig(mode=EngagementMode.ON_REQUEST)
    rig.frames(40)
    rig.session.authorise(OTHERS)
    answer = rig.session.request_engage(rig.now_ns, READY)
    assert (answer.done, answer.reason.code) == (False, Code.NO_HAND)


@pytest.mark.parametrize("trouble", [NO_OFFSET, OLD_OFFSET])
def test_a_clock_that_is_not_known_any_more_holds_the_arm(trouble):
    rig = engaged()
    rig.session.sample(trouble)
    decision = rig.wait(4)
    assert (decision.state, decision.reason.code) == (SessionState.HOLDING, trouble.reason.code)


HELD_DOWN = [(EngagementMode.HOLD_TO_RUN, "key"), (EngagementMode.PEDAL, "pedal")]


def held(mode=EngagementMode.HOLD_TO_RUN):
    rig = Rig(mode=mode)
    rig.frames(30)
    assert rig.frames(1, held=True).action is Action.CAPTURE
    return rig


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


def test_letting_go_for_a_single_sample_is_a_clutch():
    rig = held()
    assert rig.frames(1).state is SessionState.DISENGAGED
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_an_input_held_before_all_is_ready_counts_when_it_is():
    rig = Rig(mode=EngagementMode.HOLD_TO_RUN)
    rig.frames(1)
    assert rig.frames(28, held=True).state is SessionState.DISENGAGED
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_an_input_that_was_never_seen_let_go_engages_nothing():
    rig = Rig(mode=EngagementMode.HOLD_TO_RUN)
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
        lambda rig: (rig.session.fault("x"), rig.session.reset()),
        lambda rig: rig.session.request_disengage(),
    ],
)
def test_an_input_still_held_after_the_end_of_an_engagement_has_to_be_pressed_anew(end):
    rig = held()
    end(rig)
    assert rig.frames(90, held=True).state is not SessionState.ENGAGED
    rig.frames(1)
    assert rig.frames(1, held=True).action is Action.CAPTURE


def test_an_input_held_while_the_hand_was_away_has_to_be_pressed_anew():
    rig = Rig(mode=EngagementMode.HOLD_TO_RUN)
    rig.frames(5)
    rig.frames(5, held=True)
    rig.wait(600)
    assert rig.frames(90, held=True).state is SessionState.DISENGAGED


def test_letting_go_counts_even_in_a_sample_whose_hand_is_lost():
    rig = held()
    rig.session.sample(Rejected(reason(Code.LOST, reason="gone"), hand_lost=True, held=False))
    assert rig.wait(4).reason.code is Code.LET_GO


def test_the_key_means_nothing_where_engagement_is_automatic():
    rig = engaged()
    rig.frames(5, held=True)
    assert rig.frames(5).action is Action.FOLLOW


def test_readiness_is_told_apart_from_what_the_operator_wants():
    rig = Rig(mode=EngagementMode.HOLD_TO_RUN)
    rig.frames(10)
    assert rig.session.readiness(rig.now_ns, READY).reason.code is Code.COLLECTING
    rig.frames(20)
    assert rig.session.readiness(rig.now_ns, READY).reason.code is Code.READY
    assert not rig.session.held
    rig.frames(1, held=True)
    assert rig.session.held
    rig.session.fault("x")
    answer = rig.session.readiness(rig.now_ns, READY)
    assert (answer.done, answer.reason.code) == (False, Code.FAULT)


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


class HeldMachine(RuleBasedStateMachine):
    """Arbitrary presses, losses and leases: the arm follows only while the key is held, after a press of its own."""

    def __init__(self):
        super().__init__()
        self.session = Session(SafetyConfig(), EngagementConfig(frames=3, mode=EngagementMode.HOLD_TO_RUN))
        self.now_ns = 10_000 * NS_PER_MS
        self.lease = None
        self.told = False
        self.pressed = False  # since the last end of anything, the key was seen up and then down
        self.seen_up = False

    def end(self):
        self.pressed = self.seen_up = False

    @rule(count=st.integers(1, 8), down=st.booleans())
    def see(self, count, down):
        for _ in range(count):
            self.now_ns += PERIOD
            if self.lease is not None:
                self.session.sample(good(self.now_ns, held=down))
                self.told = down
                self.seen_up |= not down
                self.pressed = down and self.seen_up
            self.step(READY)

    @rule(ticks=st.integers(1, 40), robot=st.sampled_from([READY, READY, DEAD]))
    def pass_time(self, ticks, robot):
        for _ in range(ticks):
            self.now_ns += 16 * NS_PER_MS
            self.step(robot)

    @rule(lease=st.sampled_from([None, LEASE, OTHERS]))
    def authorise(self, lease):
        if lease is not self.lease:
            self.end()
        self.lease = lease
        self.session.authorise(lease)

    @rule()
    def fail_and_reset(self):
        self.session.fault("x")
        self.end()
        self.session.reset()

    @rule()
    def engage(self):
        assert not self.session.request_engage(self.now_ns, READY).done or self.pressed

    def step(self, robot):
        followed = self.session.state in FOLLOWING
        decision = self.session.tick(self.now_ns, robot)
        if decision.action is not Action.STOP:
            assert self.lease is not None
            assert self.told
            assert self.pressed
        if followed and decision.state not in FOLLOWING:
            self.end()


TestHeldMachine = HeldMachine.TestCase
TestHeldMachine.settings = settings(max_examples=80, stateful_step_count=40, deadline=None, derandomize=True)
