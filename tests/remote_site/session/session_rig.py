"""A session with its clock, and the samples, robots and leases that its tests feed it."""

from dataclasses import replace
from typing import Any

import numpy as np
from msgspec import structs

from common.clock import NS_PER_MS
from common.messages.hand import Intent
from common.messages.robot import SessionState
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.age_limit import AgeLimitChoice
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.lease import Holder, Lease
from remote_site.session.samples import Accepted, Rejected
from remote_site.session.state_machine import Action, Decision, Robot, Session
from tests.remote_site.remote_loop import hand

REST = JointMotion.at_rest(np.zeros(6))
READY = Robot(None, REST)
MOVING = Robot(None, replace(REST, dq=np.ones(6)))
STARTING = Robot(None, REST, site_ready=False)
DEAD = Robot(RobotFault(FaultCode.ROBOT, "brakes on"), REST)
LEASE = Lease(41, Holder(7, "anna"), 10**18)
OTHERS = Lease(42, Holder(8, "ben"), 10**18)
PERIOD = 33 * NS_PER_MS
LOST = Rejected(reason(Code.LOST, reason="gone"), hand_lost=True)
NO_OFFSET = Rejected(reason(Code.NO_OFFSET))
OLD_OFFSET = Rejected(reason(Code.OLD_OFFSET, age_ms=5001, limit_ms=5000))
JUMPS = Rejected(reason(Code.JUMPS, point="wrist", count=3), latch=True)


def good(born_ns: int, new_session: bool = False, held: bool = False) -> Accepted:
    """An accepted sample born at `born_ns`."""
    return Accepted(hand(1, born_ns, intent=Intent(hold=held)), np.zeros(3), None, born_ns, new_session)


class SessionRig:
    """A session under anna's lease, and its clock."""

    def __init__(self, **engagement: Any) -> None:
        safety, mode = SafetyConfig(), {"mode": EngagementMode.AUTOMATIC}
        self.session = Session(safety, EngagementConfig(**mode | engagement), AgeLimitChoice(safety).limit)
        self.session.authorise(LEASE)
        self.now_ns = 10_000 * NS_PER_MS

    def frames(self, count: int, robot: Robot = READY, held: bool = False) -> Decision:
        """Feed `count` good samples at the camera's rate, each followed by a tick; the last decision."""
        for _ in range(count):
            self.now_ns += PERIOD
            self.session.sample(good(self.now_ns, held=held))
            decision = self.session.tick(self.now_ns, robot)
        return decision

    def unreported(self) -> Decision:
        """A good sample without an intent, and a tick."""
        self.now_ns += PERIOD
        sample = good(self.now_ns)
        self.session.sample(replace(sample, sample=structs.replace(sample.sample, intent=None)))
        return self.session.tick(self.now_ns, READY)

    def wait(self, milliseconds: float, robot: Robot = READY) -> Decision:
        """One tick after this time without a sample."""
        self.now_ns += round(milliseconds * NS_PER_MS)
        return self.session.tick(self.now_ns, robot)


def engaged(**engagement: Any) -> SessionRig:
    """Engaged by good samples alone."""
    rig = SessionRig(**engagement)
    rig.frames(30)
    assert rig.session.state is SessionState.ENGAGED
    return rig


def held(mode: EngagementMode = EngagementMode.HOLD_TO_RUN) -> SessionRig:
    """Engaged by a key or pedal that is still held down."""
    rig = SessionRig(mode=mode)
    rig.frames(30)
    assert rig.frames(1, held=True).action is Action.CAPTURE
    return rig
