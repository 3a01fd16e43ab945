"""The simulated operator filmed and tracked, and two methods from the film to the tool's motion; on stepped time."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from common.cameras.camera import Frame
from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.errors import ProcessError
from common.geometry import Array, hand_rotation
from common.mapping.relative_mapping import RelativeMapping
from common.messages.hand import ClockSync, HandArm, TrackingStatus
from common.messages.robot import SessionState
from lab.experiments.report import Progress
from lab.stage.stepped.kinematic_loop import KinematicLoop
from lab.stage.stepped.robots import SteppedRobot
from lab.stage.stepped.site import FOR_EVER_NS, LEASE, OPERATOR, SESSION, SteppedSite
from local_site.samples.hand_sample import GestureConfig, HandSampler, OpenHand
from local_site.samples.smoothing import SmoothingConfig, make_smoother
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.config import SimulationConfig
from local_site.simulation.motion import Path
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, View, Views
from remote_site.config import RemoteConfig
from remote_site.kinematics.inverse import Solution, SphericalWristInverse
from remote_site.kinematics.limits import load_arm
from remote_site.reasons import Code
from remote_site.session.config import EngagementMode
from remote_site.session.lease import Holder, Lease, LeaseStatus
from remote_site.session.samples import NamedSample
from remote_site.teleop.cycle import Snapshot

NOT_USED = (TrackingStatus.LOST, TrackingStatus.INITIALISING)


@dataclass(frozen=True, slots=True)
class Film:
    """The tracker's measurements in every frame, unsmoothed, at `fps` from time zero of the operator's motion."""

    operator: SimulatedOperator
    fps: float
    estimates: tuple[ArmEstimate, ...]


def film(
    config: SimulationConfig,
    tracking: TrackingConfig,
    fps: float,
    seconds: float,
    progress: Progress,
    path: Path | None = None,
) -> Film:
    """Render and track all frames of `seconds`; deterministic by the configuration's seed.

    The hand moves along `path` where one is given, else as the configuration names it.
    """
    cv2.setNumThreads(1)
    operator = SimulatedOperator(config, path)
    tracker = make_tracker(calibrate_simulated(config), tracking)
    estimates: list[ArmEstimate] = []
    for k in range(round(seconds * fps) + 1):
        t_ns = round(k * NS_PER_S / fps)
        views = tuple(View(Frame(picture, t_ns, k)) for picture in operator.render(t_ns / NS_PER_S))
        estimates.append(tracker.track(Views(t_ns, views)))
        progress()
    return Film(operator, fps, tuple(estimates))


@dataclass
class ToolPath:
    """The path of the tool: `base_T_tool` (4 x 4) at times in ns, since both origins were taken at `engaged_ns`.

    `postures` are the joints there, rad, and `openings_m` the gripper's, NaN where none is measured. `hindered` counts,
    by code, what kept the tool from its target: samples as in the thesis, ticks in the pipeline.
    """

    engaged_ns: int = -1
    times_ns: list[int] = field(default_factory=list)
    poses: list[Array] = field(default_factory=list)
    postures: list[Array] = field(default_factory=list)
    openings_m: list[float] = field(default_factory=list)
    hindered: Counter[str] = field(default_factory=Counter)

    def add(self, t_ns: int, q: Array, base_T_tool: Array, opening_m: float = math.nan) -> None:
        """Note the joints, the tool's pose and the gripper's opening at a time later than the last."""
        self.times_ns.append(t_ns)
        self.postures.append(q.copy())
        self.poses.append(base_T_tool.copy())
        self.openings_m.append(opening_m)

    def since(self, start_ns: int) -> "ToolPath":
        """Return the same path with its times counted from `start_ns`."""
        times_ns = [t_ns - start_ns for t_ns in self.times_ns]
        return replace(self, engaged_ns=self.engaged_ns - start_ns, times_ns=times_ns)

    def follow(self, snapshot: Snapshot, t_ns: int, q: Array, base_T_tool: Array, opening_m: float = math.nan) -> None:
        """Note the same once the arm has been engaged, and what hinders it now."""
        if snapshot.engagement is None:
            return
        if self.engaged_ns < 0:
            self.engaged_ns = snapshot.engagement.hand_capture_ns
        if snapshot.state is not SessionState.ENGAGED or snapshot.reason.code is not Code.OK:
            self.hindered[snapshot.reason.code.value] += 1
        self.add(t_ns, q, base_T_tool, opening_m)


def follow_by_mean(film: Film, smoothing: SmoothingConfig, remote: RemoteConfig) -> ToolPath:
    """The thesis's method: smooth, map, and reach each target without delay, frame by frame.

    Origins are taken once the mean holds only frames since the arm was learnt. The robot's own lag and the time of
    tracking are left out. ProcessError when the hand is never tracked that long.
    """
    model, limits = load_arm(remote.robot)
    mapping, smoother = RelativeMapping(remote.mapping), make_smoother(smoothing)
    inverse = SphericalWristInverse(model, limits, remote.robot.stance)
    q, path, tracked = remote.robot.start, ToolPath(), 0
    for estimate in map(smoother.smooth, film.estimates):
        is_tracked = estimate.wrist is not None and estimate.status not in NOT_USED
        tracked = tracked + 1 if is_tracked else 0
        if estimate.wrist is not None and is_tracked and (path.engaged_ns >= 0 or tracked == smoothing.mean_frames):
            if path.engaged_ns < 0:
                mapping.engage(estimate.wrist, _orientation(estimate), model.forward(q))
                path.engaged_ns = estimate.t_ns
            target = mapping.target(estimate.wrist, _orientation(estimate))
            reached = inverse.nearest(target, q, 1.0 / film.fps)
            if isinstance(reached, Solution):
                q = reached.q
            else:
                path.hindered[reached.reason.code.value] += 1
        if path.engaged_ns >= 0:
            path.add(estimate.t_ns, q, model.forward(q))
    return _engaged(path)


def follow_by_pipeline(film: Film, smoothing: SmoothingConfig, remote: RemoteConfig, latency_ms: float) -> ToolPath:
    """Farhand's method: smooth, send, and follow through the whole pipeline with a robot that follows exactly.

    Samples come `latency_ms` after their exposure. ProcessError when the arm is never engaged.
    """
    return follow_estimates(map(make_smoother(smoothing).smooth, film.estimates), remote, latency_ms)


def follow_estimates(estimates: Iterable[ArmEstimate], remote: RemoteConfig, latency_ms: float) -> ToolPath:
    """Send estimates as they are, and follow as `follow_by_pipeline` does."""
    arm = FollowingArm(remote)
    for estimate in estimates:
        arm.run_until(estimate.t_ns + round(latency_ms * NS_PER_MS))
        arm.send(estimate)
    return _engaged(arm.path)


def follow_on_robot(
    film: Film,
    smoothing: SmoothingConfig,
    remote: RemoteConfig,
    latency_ms: float,
    robot: SteppedRobot,
    progress: Progress,
) -> ToolPath:
    """Farhand's method with a robot that lags: smooth, count openings, send; pipeline, driver and supervisor follow.

    The tool is where the robot's joints truly are. Samples come `latency_ms` after their exposure. ProcessError when
    the arm is never engaged.
    """
    smoother, sampler, hand = make_smoother(smoothing), HandSampler(SESSION), OpenHand()
    site, path = SteppedSite(remote.engaging(EngagementMode.AUTOMATIC), robot), ToolPath()
    start_ns, latency_ns = site.now_ns, round(latency_ms * NS_PER_MS)
    received: list[NamedSample] = []
    for estimate in film.estimates:
        while site.now_ns - start_ns < estimate.t_ns + latency_ns:
            snapshot = site.tick(received)
            received = []
            opening_m = math.nan if site.gripper is None else site.gripper.opening
            q = robot.q
            path.follow(snapshot, site.now_ns, q, site.model.forward(q), opening_m)
        hand = hand.observe(estimate, GestureConfig())
        received = [NamedSample(OPERATOR, _sample(sampler, smoother.smooth(estimate), hand, start_ns))]
        progress()
    return _engaged(path).since(start_ns)


def _sample(sampler: HandSampler, estimate: ArmEstimate, hand: OpenHand, start_ns: int) -> HandArm:
    """Make the sample of an estimate as it is sent, with the times of a site that began at `start_ns`."""
    t_ns = start_ns + estimate.t_ns
    clock = ClockSync(remote_minus_local_ns=0, uncertainty_ns=0, measured_ns=t_ns)
    return sampler.sample(replace(estimate, t_ns=t_ns), hand, LEASE, clock, None, t_ns)


class FollowingArm:
    """The remote site's pipeline around the kinematic driver, on a clock that is moved tick by tick."""

    def __init__(self, remote: RemoteConfig) -> None:
        self._tick_ns = round(NS_PER_S / remote.control.rate_hz)
        self._clock = FakeClock()
        self.loop = KinematicLoop(remote, self._clock)
        self._lease = LeaseStatus(Lease(LEASE, Holder(SESSION, OPERATOR), FOR_EVER_NS))
        self._sampler = HandSampler(SESSION)
        self._received: list[NamedSample] = []
        self.path = ToolPath()

    def send(self, estimate: ArmEstimate) -> None:
        """Let an estimate arrive with the next tick, as the local site sends it."""
        self._received.append(NamedSample(OPERATOR, _sample(self._sampler, estimate, OpenHand(), 0)))

    def run_until(self, end_ns: int) -> None:
        """Tick until the next tick would be at `end_ns` or later."""
        while self._clock.now_ns() + self._tick_ns < end_ns:
            self._clock.sleep_until_ns(self._clock.now_ns() + self._tick_ns)
            samples, self._received = self._received, []
            command = self.loop.cycle(self._lease, samples)
            q = command.motion.q
            self.path.follow(command.snapshot, command.snapshot.now_ns, q, self.loop.model.forward(q))


def _orientation(estimate: ArmEstimate) -> Array | None:
    """Compute the hand's orientation, its thumb seen or inferred (thesis section 3.2.11); None while it is open."""
    if estimate.wrist is None or estimate.index is None or estimate.thumb is None or estimate.hand_open:
        return None
    return hand_rotation(*(np.asarray(point) for point in (estimate.wrist, estimate.index, estimate.thumb)))


def _engaged(path: ToolPath) -> ToolPath:
    if path.engaged_ns < 0:
        raise ProcessError("the arm was never engaged: the hand was not tracked long enough; check the tracking")
    return path
