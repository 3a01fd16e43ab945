"""What holds for the session whatever happens, in any order."""

from dataclasses import replace

import msgspec
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from common.clock import NS_PER_MS
from common.messages.hand import ClutchKey, Intent
from common.messages.robot import FOLLOWING, SessionState
from remote_site.safety.config import SafetyConfig
from remote_site.session.age_limit import AgeLimitChoice
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.state_machine import Action, Session
from tests.present import present
from tests.remote_site.session.session_rig import (
    DEAD,
    JUMPS,
    LEASE,
    LOST,
    MOVING,
    OTHERS,
    PERIOD,
    READY,
    good,
)

SAFETY = SafetyConfig()
LIMIT = AgeLimitChoice(SAFETY).limit


class SessionMachine(RuleBasedStateMachine):
    """Arbitrary events; the arm follows only on fresh samples of an engagement that was granted."""

    def __init__(self):
        super().__init__()
        self.session = Session(SAFETY, EngagementConfig(frames=3, mode=EngagementMode.AUTOMATIC), LIMIT)
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
        self.session.request_disengage(self.now_ns)
        self.end()

    @rule()
    def fail(self):
        self.session.fault("x", self.now_ns)
        self.end()

    @rule()
    def reset(self):
        self.session.reset()

    def end(self):
        self.granted = self.captured = False

    def step(self, robot):
        self.decision = self.session.tick(self.now_ns, robot)
        if self.decision.action in (Action.CAPTURE, Action.RESUME):
            assert self.granted
            assert robot is READY
            self.captured = True
        if self.decision.action is Action.FOLLOW:
            assert self.captured
        if self.decision.action is not Action.STOP:
            assert self.decision.state is SessionState.ENGAGED
            assert self.now_ns - present(self.born_ns) <= 100 * NS_PER_MS
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
        self.session = Session(SAFETY, EngagementConfig(frames=3, mode=EngagementMode.HOLD_TO_RUN), LIMIT)
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
        self.session.fault("x", self.now_ns)
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


class ClutchMachine(RuleBasedStateMachine):
    """Arbitrary reports of the clutch: the arm follows only 200 ms after a release in a row of reports."""

    def __init__(self):
        super().__init__()
        self.session = Session(SAFETY, EngagementConfig(frames=3), LIMIT)
        self.session.authorise(LEASE)
        self.now_ns = 10_000 * NS_PER_MS
        self.before, self.is_held, self.released_ns = ClutchKey.UP, False, None

    @rule(count=st.integers(1, 9), key=st.sampled_from([*ClutchKey, None]))
    def see(self, count, key):
        for _ in range(count):
            self.now_ns += PERIOD
            sample = good(self.now_ns)
            intent = None if key is None else Intent(clutch=key)
            self.session.sample(replace(sample, sample=msgspec.structs.replace(sample.sample, intent=intent)))
            self.note(key)
            self.step()

    def note(self, key):
        if key in (ClutchKey.DOWN, ClutchKey.UNSEEN):
            self.is_held = True
        elif self.is_held and (self.before, key) == (ClutchKey.DOWN, ClutchKey.UP):
            self.is_held, self.released_ns = False, self.now_ns
        self.before = key

    @rule()
    def lose(self):
        self.session.sample(LOST)
        self.released_ns = self.now_ns if self.released_ns is not None else None

    @rule(ticks=st.integers(1, 60))
    def pass_time(self, ticks):
        for _ in range(ticks):
            self.now_ns += 16 * NS_PER_MS
            self.step()

    @rule()
    def engage(self):
        done = self.session.request_engage(self.now_ns, READY).done
        assert not (done and self.is_held and self.session.state is SessionState.DISENGAGED)

    def step(self):
        decision = self.session.tick(self.now_ns, READY)
        if decision.action is not Action.STOP:
            assert not self.is_held
        if decision.action in (Action.CAPTURE, Action.RESUME) and self.released_ns is not None:
            assert self.now_ns - self.released_ns >= 200 * NS_PER_MS
            self.released_ns = None


TestClutchMachine = ClutchMachine.TestCase
TestClutchMachine.settings = settings(max_examples=80, stateful_step_count=40, deadline=None, derandomize=True)
