"""One trial: the scripted visual operator places the block, in lockstep with simulated time."""

from collections import deque
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
from msgspec.structs import replace

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.hand import HandArm, Locks
from common.messages.robot import GripperStatus, SessionState
from farhand.experiments.placing.judge import Judge, Placed
from farhand.experiments.placing.stepped_site import OPERATOR, SteppedSite
from farhand.experiments.placing.streamed_views import StreamedViews
from farhand.experiments.placing.tracked_operator import TrackedOperator
from farhand.experiments.placing.true_sight import TrueSight
from farhand.visual_operator.hand import Motor, ScriptedHand
from farhand.visual_operator.operator import VisualOperator
from farhand.visual_operator.shown import Shown, ShownView
from farhand.visual_operator.sight.sight import Sight
from farhand.visual_operator.task import PlacingTask
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.config import Method
from remote_site.config import RemoteConfig
from remote_site.session.config import EngagementMode
from remote_site.session.samples import NamedSample

T = TypeVar("T")
Exact = Literal["tracker", "sight", "hand"]
TRACKING_NS, LINK_NS = 20 * NS_PER_MS, 5 * NS_PER_MS  # from an exposure to the sample sent; on its way
PICTURE_NS = 60 * NS_PER_MS  # from the exposure of a view to the page
CAMERA_NS, PAGE_NS = NS_PER_S // 30, NS_PER_S // 10
MOST_S = 120.0
# Where the block starts (thesis section 5.3): its middle anywhere in a disc of 150 mm, turned by at most 30 deg.
START_XY_M, START_RADIUS_M, START_TURN_DEG = (0.53, 0.04), 0.075, 30.0
WRIST_M = (0.60, 0.42, 0.58)  # of the operator, at the start


@dataclass(frozen=True, slots=True)
class Conditions:
    """What differs between trials: the tracker, whether the tool's roll is locked, and everything by chance.

    `exact` is what is replaced by the truth: cameras and tracker, the operator's sight, or its hand, which is then
    without noise.
    """

    method: Method
    roll_fixed: bool
    seed: int
    exact: Exact | None = None


@dataclass(frozen=True, slots=True)
class TrialResult:
    """The outcome of a trial; `holds` is how often the arm held by itself, `grip_force_n` the largest at a finger."""

    end: Placed
    time_s: float
    drops: int
    collisions: int
    clutches: int
    misses: int
    holds: int
    grip_force_n: float


def run_trial(conditions: Conditions) -> TrialResult:
    """Run a trial to its end; the same for the same conditions."""
    rng = np.random.default_rng(conditions.seed)
    config = remote_config(rng)
    site = SteppedSite(config)
    judge = Judge(config, site.cell)
    trial = _Trial(conditions, config, site)
    while not trial.operator.done and trial.time_s < MOST_S:
        trial.step()
        judge.watch()
    return TrialResult(
        judge.placed(),
        trial.time_s,
        judge.drops,
        judge.collisions,
        trial.operator.notes.clutches,
        trial.operator.notes.misses,
        trial.holds,
        judge.grip_force_n,
    )


class _Trial:
    """Operator, cameras, site and views, each at its own rate; what is under way between them."""

    def __init__(self, conditions: Conditions, config: RemoteConfig, site: SteppedSite) -> None:
        self._site, task, exact = site, PlacingTask(), conditions.exact
        true_sight = TrueSight(config, site) if exact == "sight" else None
        self._views = true_sight or StreamedViews(config, site.memory, site.description)
        see = true_sight.see if true_sight is not None else Sight(task).see
        hand = ScriptedHand(Motor(noise_m=0.0, noise_rad=0.0) if exact == "hand" else Motor(), conditions.seed)
        mapping, locks = site.description.mapping, Locks(roll=conditions.roll_fixed)
        self.operator = VisualOperator(task, see, mapping, hand, locks)
        filmed = SimulationConfig(motion=MotionConfig(still_s=0.0, wrist=WRIST_M), seed=conditions.seed)
        filmed = replace(filmed, markers=conditions.method == "markers")
        tracking = TrackingConfig(method=conditions.method)
        self._arm = TrackedOperator(filmed, tracking, hand, exact=exact == "tracker")
        self._start_ns = site.now_ns
        self._exposures, self._looks = _Every(CAMERA_NS, site.now_ns), _Every(PAGE_NS, site.now_ns)
        self._samples: deque[tuple[int, HandArm]] = deque()
        self._pages: deque[tuple[int, dict[str, ShownView]]] = deque()
        self.holds, self._held = 0, False

    @property
    def time_s(self) -> float:
        """How long the trial has lasted."""
        return (self._site.now_ns - self._start_ns) / NS_PER_S

    def step(self) -> None:
        """One control period of the remote site."""
        now_ns = self._site.now_ns
        if self._exposures.due(now_ns):
            sent_ns = now_ns + TRACKING_NS
            sample = self._arm.sample(self._arm.see(now_ns, self._start_ns), self.operator.intent, sent_ns)
            self._samples.append((sent_ns + LINK_NS, sample))
        if self._looks.due(now_ns):
            self._pages.append((now_ns + PICTURE_NS, dict(self._views.look(now_ns))))
        for views in _arrived(self._pages, now_ns):
            self.operator.look(self._shown(views), self._start_ns)
        snapshot = self._site.tick([NamedSample(OPERATOR, sample) for sample in _arrived(self._samples, now_ns)])
        held = snapshot.state is SessionState.HOLDING
        self.holds += held and not self._held
        self._held = held

    def _shown(self, views: dict[str, ShownView]) -> Shown:
        snapshot, gripper = self._site.snapshot, self._site.gripper
        opening, status = (gripper.opening, gripper.status) if gripper is not None else (0.0, GripperStatus.UNKNOWN)
        return Shown(
            self._site.now_ns,
            views,
            snapshot.state,
            snapshot.reason.code.value,
            snapshot.reason.sentence,
            opening,
            status,
        )


class _Every:
    """Is due once in each period, from a first time on."""

    def __init__(self, period_ns: int, first_ns: int) -> None:
        self._period_ns, self._next_ns = period_ns, first_ns

    def due(self, now_ns: int) -> bool:
        is_due = now_ns >= self._next_ns
        self._next_ns += self._period_ns if is_due else 0
        return is_due


def _arrived(under_way: deque[tuple[int, T]], now_ns: int) -> list[T]:
    """Take out what has arrived by now, oldest first."""
    arrived = []
    while under_way and under_way[0][0] <= now_ns:
        arrived.append(under_way.popleft()[1])
    return arrived


def remote_config(rng: np.random.Generator) -> RemoteConfig:
    """The cell with calibrated views and the block at a random start."""
    config = RemoteConfig().engaging(EngagementMode.HOLD_TO_RUN)
    angle, radius = rng.uniform(0, 2 * np.pi), START_RADIUS_M * np.sqrt(rng.uniform())
    x, y = START_XY_M[0] + radius * np.cos(angle), START_XY_M[1] + radius * np.sin(angle)
    yaw_deg = float(rng.uniform(-START_TURN_DEG, START_TURN_DEG))
    block = replace(config.simulation.block, centre_xy_m=(float(x), float(y)), yaw_deg=yaw_deg)
    video = replace(config.video, calibrated=True, fps=NS_PER_S / PAGE_NS)
    return replace(config, video=video, simulation=replace(config.simulation, block=block))
