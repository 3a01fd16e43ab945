"""The pure chain of the remote site, tick by tick, with every command that the driver received."""

import numpy as np

from common.clock import NS_PER_MS, FakeClock
from common.messages.hand import ClockSync, HandArm, TrackingStatus
from common.messages.robot import SessionState
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code
from remote_site.safety.clearance import ClearanceCheck, Workspace
from remote_site.safety.collision import CollisionModel
from remote_site.safety.guard import Guard, Passed
from remote_site.session.lease import Holder, LeaseServer
from remote_site.session.state_machine import Robot, Session
from remote_site.teleop.pipeline import TeleopPipeline

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
TICKS_PER_JUDGEMENT = 5  # the chain has a guard of its own; another whole one doubles the time
START_NS = 10_000 * NS_PER_MS
FOR_EVER_NS = 10**15
LEASE = 41


def arm(config: RemoteConfig | None = None) -> tuple[ArmModel, JointLimits]:
    """The configured arm and its limits."""
    robot = (config or RemoteConfig()).robot
    model = ArmModel.from_urdf(robot.urdf, robot.tool_frame, robot.tool_T_tcp)
    return model, JointLimits.from_model(model, robot)


def workspace(config: RemoteConfig | None = None) -> Workspace:
    """The configured box."""
    safety = (config or RemoteConfig()).safety
    return Workspace(np.array(safety.workspace_min_m), np.array(safety.workspace_max_m))


def guard_of(config: RemoteConfig | None = None, box: Workspace | None = None) -> Guard:
    """The guard of the configured arm, with another box if one is given."""
    config = config or RemoteConfig()
    _, limits = arm(config)
    return Guard(limits, surroundings(config, box), TICK_NS / 1e9)


def surroundings(config: RemoteConfig | None = None, box: Workspace | None = None) -> ClearanceCheck:
    """The configured arm's surroundings, with another box if one is given."""
    config = config or RemoteConfig()
    model, _ = arm(config)
    robot = config.robot
    collision = CollisionModel.from_urdf(robot.urdf, model, robot.capsules, config.safety.collision)
    return ClearanceCheck(model, box or workspace(config), collision)


def hand(seq, capture_ns, wrist=(0.0, 0.0, 0.3), session=7, status=TrackingStatus.TRACKED, **changes) -> HandArm:
    """A tracked sample, with changes."""
    x, y, z = wrist if wrist is not None else (0.0, 0.0, 0.0)
    fields = {
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


class RemoteLoop:
    """The chain around a kinematic robot, on a fake clock."""

    def __init__(self, config: RemoteConfig | None = None) -> None:
        self.config = config or RemoteConfig()
        self.model, self.limits = arm(self.config)
        self.clock = FakeClock(START_NS)
        self.leases = LeaseServer(FOR_EVER_NS, LEASE)
        self.grant(7)
        self.chain = TeleopPipeline(self.config, self.model, self.limits, self.config.robot.start, self.leases)
        self.guard = guard_of(self.config)
        self.driver = KinematicDriver(self.clock)
        setup = DriverSetup(self.model.joint_names, self.limits, TICK_NS / 1e9, 50 * NS_PER_MS)
        self.driver.configure(setup)
        self.driver.activate(self.config.robot.start)
        self.log: list[JointMotion] = [self.sent]
        self.states = []
        self.refusals = self.saturated = 0
        self.seq = 0

    def grant(self, session: int) -> None:
        """Give the lease to a local site, whoever has it."""
        now_ns = self.clock.now_ns()
        held = self.leases.current(now_ns)
        if held is not None:
            self.leases.release(held.number, held.holder.session, now_ns)
        self.lease = self.leases.acquire(Holder(session, f"operator-{session}"), now_ns).number

    @property
    def sent(self) -> JointMotion:
        """What was really sent last."""
        return self.chain.sent

    @property
    def session(self) -> Session:
        """The chain's session."""
        return self.chain.session

    @property
    def robot(self) -> Robot:
        """What the session sees of the robot."""
        return self.chain.robot(None)

    def tick(self, *samples: HandArm) -> None:
        """One control tick: the samples that have come, then a decision, then a command."""
        self.clock.advance_ms(TICK_NS / NS_PER_MS)
        now_ns = self.clock.now_ns()
        for sample in samples:
            self.chain.receive(sample, now_ns)
        step = self.chain.tick(now_ns, self.robot)
        self.refusals += step.state is SessionState.ENGAGED and step.reason.code in REFUSALS
        self.saturated += step.reason.code is Code.SATURATED
        self.write(step.motion, now_ns)
        self.states.append(step.state)

    def write(self, motion: JointMotion, now_ns: int) -> None:
        """Judge the motion, now and then, once more, then the driver; every command is logged as sent."""
        self.seq += 1
        if self.seq % TICKS_PER_JUDGEMENT == 0:
            verdict = self.guard.check(motion, self.sent)
            assert isinstance(verdict, Passed), verdict
        command = JointCommand(self.seq, now_ns, motion.q, motion.dq, motion.ddq, self.chain.gripper.is_open)
        self.chain.sent = self.driver.write(command).motion
        assert self.sent.q is motion.q  # the driver's own limits had nothing to object to
        self.log.append(self.sent)

    def run(self, ticks: int, wrist=None, every: int = 8, session: int = 7, **changes) -> None:
        """Run with a sample every so many ticks, captured a tick before it comes; `wrist(t_ns)` in m."""
        for k in range(ticks):
            samples = []
            if wrist is not None and k % every == 0:
                capture_ns = self.clock.now_ns()
                self.hand_seq = getattr(self, "hand_seq", 0) + 1
                fields = {"session": session, "lease": self.lease} | changes
                samples = [hand(self.hand_seq, capture_ns, wrist(capture_ns), **fields)]
            self.tick(*samples)

    def arrays(self):
        """The log as arrays (ticks, joints): q, dq, ddq."""
        return tuple(np.array([getattr(motion, name) for motion in self.log]) for name in ("q", "dq", "ddq"))


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
