"""The pipeline of the remote site, tick by tick, with every command that the driver received."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from common.clock import NS_PER_MS, FakeClock
from common.geometry import Array
from common.messages.hand import ClockSync, HandArm, TrackingStatus
from common.messages.requests import EngagementAction
from common.messages.robot import GripperCommand, SessionState
from lab.stage.stepped.kinematic_loop import KinematicLoop
from remote_site.assist.sighting import MarkerSighting
from remote_site.config import RemoteConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits, load_arm
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code
from remote_site.safety.clearance import ClearanceCheck, Workspace
from remote_site.safety.collision import CollisionModel
from remote_site.safety.guard import Guard, Passed
from remote_site.session.lease import Holder, Lease, LeaseServer
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import Accepted, NamedSample
from remote_site.session.state_machine import Answer, Robot, Session
from remote_site.teleop.cycle import Snapshot

TICK_NS = 4 * NS_PER_MS
REFUSALS = {
    Code.POSITION,
    Code.VELOCITY,
    Code.ACCELERATION,
    Code.JERK,
    Code.INCONSISTENT,
    Code.WORKSPACE,
    Code.COLLISION,
    Code.NO_TRAJECTORY,
}
TICKS_PER_JUDGEMENT = 5  # the pipeline has a guard of its own; another whole one doubles the time
START_NS = 10_000 * NS_PER_MS
FOR_EVER_NS = 10**15
LEASE = 41
Point = tuple[float, float, float]


def arm(config: RemoteConfig | None = None) -> tuple[ArmModel, JointLimits]:
    """The configured arm and its limits."""
    return load_arm((config or RemoteConfig()).robot)


def workspace(config: RemoteConfig | None = None) -> Workspace:
    """The configured box."""
    safety = (config or RemoteConfig()).safety
    return Workspace(np.array(safety.workspace_min_m), np.array(safety.workspace_max_m))


def guard_of(config: RemoteConfig | None = None, box: Workspace | None = None) -> Guard:
    """The guard of the configured arm, with another box if one is given."""
    config = config or RemoteConfig()
    _, limits = arm(config)
    return Guard(limits, clearance(config, box), TICK_NS / 1e9)


def clearance(config: RemoteConfig | None = None, box: Workspace | None = None) -> ClearanceCheck:
    """The configured arm's clearance check, with another box if one is given."""
    config = config or RemoteConfig()
    return ClearanceCheck(arm(config)[0], box or workspace(config), collision_model(config))


def collision_model(config: RemoteConfig) -> CollisionModel:
    """The configured arm's distances."""
    robot = config.robot
    return CollisionModel.from_urdf(robot.urdf, arm(config)[0], robot.capsules, config.safety.collision)


def hand(
    seq: int,
    capture_ns: int,
    wrist: Point | None = (0.0, 0.0, 0.3),
    session: int = 7,
    status: TrackingStatus = TrackingStatus.TRACKED,
    **changes: Any,
) -> HandArm:
    """A tracked sample, with changes."""
    x, y, z = wrist if wrist is not None else (0.0, 0.0, 0.0)
    fields: dict[str, Any] = {
        "elbow": (x, y + 0.25, z),
        "wrist": wrist,
        "index": (x + 0.02, y - 0.17, z),
        "thumb": (x - 0.05, y - 0.1, z + 0.01),
        "reason": "",
        "thumb_inferred": False,
        "hand_open": False,
        "gripper_toggles": 0,
        "lease": LEASE,
        "clock": ClockSync(remote_minus_local_ns=0, uncertainty_ns=0, measured_ns=capture_ns),
    }
    return HandArm(session=session, seq=seq, capture_ns=capture_ns, status=status, **(fields | changes))


def operator_of(session: int) -> str:
    """The operator of a local site's session."""
    return f"operator-{session}"


class RemoteLoop:
    """The pipeline around a kinematic robot on a fake clock; every command is judged once more, and logged."""

    def __init__(self, config: RemoteConfig | None = None) -> None:
        self.clock = FakeClock(START_NS)
        self.leases = LeaseServer(FOR_EVER_NS, LEASE)
        self.grant(7)
        self._loop = KinematicLoop(config or RemoteConfig(), self.clock)
        self.config = self._loop.config
        self.pipeline, self.model, self.limits = self._loop.pipeline, self._loop.model, self._loop.limits
        self.guard = guard_of(self.config)
        self.log: list[JointMotion] = [self.sent]
        self.states: list[SessionState] = []
        self.refusals = self.saturated = self.hand_seq = 0
        self.sender = ""  # whose key samples come on, if it is not that of their session's operator
        self.snapshot: Snapshot
        self.gripper: GripperCommand

    def grant(self, session: int) -> None:
        """Give the lease to a local site, taking it from any other."""
        now_ns = self.clock.now_ns()
        held = self.leases.current(now_ns)
        if held is not None:
            self.leases.release(held.number, held.holder, now_ns)
        granted = self.leases.acquire(Holder(session, operator_of(session)), now_ns)
        assert isinstance(granted, Lease)
        self.lease = granted.number

    @property
    def sent(self) -> JointMotion:
        """What was really sent last."""
        return self._loop.sent

    @cached_property
    def _collision(self) -> CollisionModel:
        return collision_model(self.config)

    def distance(self) -> float:
        """How near the commanded arm is to anything, in m."""
        return self._collision.distance(self.sent.q)

    @property
    def session(self) -> Session:
        """The pipeline's session."""
        return self.pipeline._session

    @property
    def newest(self) -> Accepted | None:
        """The newest sample that may be followed."""
        return self.pipeline._samples.latest

    @property
    def robot(self) -> Robot:
        """What the session sees of the robot."""
        return Robot(None, self.sent)

    def ask(self, action: EngagementAction) -> Answer:
        """One tick with a request of the lease's holder, and what is answered."""
        lease = self.leases.current(self.clock.now_ns())
        asker = lease.holder.name if lease is not None else "nobody"
        self.tick(requests=(SessionRequest(action, asker, seen_ns=self.session.halts.newest_ns),))
        return self.snapshot.answers[0]

    def tick(
        self,
        *samples: HandArm,
        requests: tuple[SessionRequest, ...] = (),
        markers: tuple[MarkerSighting, ...] = (),
    ) -> None:
        """One control tick: samples, requests and markers that have come, then a decision, then a command."""
        self.clock.advance_ms(TICK_NS / NS_PER_MS)
        before = self.sent
        named = [NamedSample(self.sender or operator_of(sample.session), sample) for sample in samples]
        command = self._loop.cycle(self.leases.status(self.clock.now_ns()), named, requests, markers)
        self.snapshot = snapshot = command.snapshot
        self.gripper = command.gripper
        if len(self.log) % TICKS_PER_JUDGEMENT == 0:
            verdict = self.guard.check(command.motion, before)
            assert isinstance(verdict, Passed), verdict
        assert self.sent.q is command.motion.q  # the driver's own limits had nothing to object to
        self.refusals += snapshot.state is SessionState.ENGAGED and snapshot.reason.code in REFUSALS
        self.saturated += snapshot.reason.code is Code.SATURATED
        self.log.append(self.sent)
        self.states.append(snapshot.state)

    def run(
        self,
        ticks: int,
        wrist: Callable[[int], Point | None] | None = None,
        every: int = 8,
        session: int = 7,
        **changes: Any,
    ) -> None:
        """Run with a sample every `every` ticks, captured a tick before it comes; `wrist(t_ns)` in m."""
        for k in range(ticks):
            samples = []
            if wrist is not None and k % every == 0:
                capture_ns = self.clock.now_ns()
                self.hand_seq += 1
                fields = {"session": session, "lease": self.lease} | changes
                samples = [hand(self.hand_seq, capture_ns, wrist(capture_ns), **fields)]
            self.tick(*samples)

    def arrays(self) -> tuple[Array, Array, Array]:
        """The log as arrays (ticks, joints): q, dq, ddq."""
        q, dq, ddq = (np.array([getattr(motion, name) for motion in self.log]) for name in ("q", "dq", "ddq"))
        return q, dq, ddq


def assert_within_limits(loop: RemoteLoop) -> None:
    """The invariant on every command that the driver received: finite, speed, acceleration, jerk, position."""
    q, dq, ddq = loop.arrays()
    limits, dt = loop.limits, TICK_NS / 1e9
    assert np.isfinite(q).all()
    assert (np.abs(dq) <= limits.velocity * 1.00001).all()
    assert (np.abs(ddq) <= limits.acceleration * 1.00001).all()
    assert (np.abs(np.diff(ddq, axis=0)) <= limits.jerk * dt * 1.00001).all()
    assert (np.abs(np.diff(q, axis=0)) <= limits.velocity * dt * 1.00001).all()
    assert (q >= limits.lower - 1e-6).all()
    assert (q <= limits.upper + 1e-6).all()
