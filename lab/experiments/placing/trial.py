"""One trial: the scripted visual operator places the block, in lockstep with simulated time."""

import dataclasses
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from msgspec.structs import replace

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, transform
from common.messages.hand import HandArm, Locks
from common.messages.robot import GripperStatus, SessionState
from lab.experiments.placing.alterations import FingerErrors, Part, at_thesis_rate, thesis_local
from lab.experiments.placing.judge import Judge, Placed
from lab.experiments.placing.marked_cell import CellMarkers, with_markers
from lab.experiments.placing.network import Messages, Network
from lab.experiments.placing.streamed_views import PICTURE_NS, StreamedViews
from lab.experiments.placing.tracked_operator import TrackedOperator
from lab.stage.stepped.robots import SteppedCell
from lab.stage.stepped.site import OPERATOR, Every, SteppedSite
from lab.visual_operator.hand import Motor, ScriptedHand
from lab.visual_operator.operator import VisualOperator
from lab.visual_operator.shown import ShownPage, ShownView
from lab.visual_operator.sight.sight import Scene, Sight
from lab.visual_operator.task import PlacingTask
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.simulation.room.config import RoomConfig
from local_site.tracking.choice import TrackingConfig
from remote_site.config import RemoteConfig
from remote_site.session.config import EngagementMode
from remote_site.session.samples import NamedSample
from remote_site.simulation.config import BLOCK

TRACKING_NS, LINK_NS = 20 * NS_PER_MS, 5 * NS_PER_MS  # from an exposure until the sample is sent; then on the link
# Periods: of exposures, of the page, and of the thesis's exposures.
CAMERA_NS, PAGE_NS, THESIS_NS = NS_PER_S // 30, NS_PER_S // 10, NS_PER_S // 5
# The thesis takes the mean of nine pictures: eight of its periods after a movement has ended, all nine show the end.
# The operator knows this delay.
THESIS_LAG_S = 1.6
EMPTY_S = 1.5  # until the operator comes into the office: 45 pairs, and a tracker learns the room from 38
MOST_S = 120.0
# Where the block starts (thesis section 5.3): its middle anywhere in a disc of 150 mm, turned by at most 30 deg.
START_XY_M, START_RADIUS_M, START_TURN_DEG = (0.53, 0.04), 0.075, 30.0
WRIST_M = (0.60, 0.42, 0.58)  # of the operator, at the start


class TrueSight:
    """Takes the simulation's poses at each exposure instead of pictures, and hands them out as the pages come."""

    def __init__(self, config: RemoteConfig, site: SteppedSite[SteppedCell]) -> None:
        self._data = site.robot.cell.data
        self._exposures = Every(round(NS_PER_S / config.video.fps), site.now_ns)
        scene = config.simulation.scene
        self._target = transform(np.eye(3), np.array([*scene.target_corner_xy_m, scene.table_z_m]))
        self._scenes: deque[Scene] = deque()

    def expose(self, now_ns: int) -> None:
        """Remember the scene, as often as pictures would be taken."""
        if self._exposures.due(now_ns):
            self._scenes.append(Scene(now_ns, self._body(BLOCK), self._fingers(), self._target))

    def page(self, now_ns: int) -> Mapping[str, ShownView]:
        """Return no views: poses are taken instead of pictures."""
        del now_ns
        return {}

    def see(self, shown: ShownPage) -> Scene:
        """Take the scene of the oldest exposure not yet seen."""
        del shown
        return self._scenes.popleft()

    def _body(self, name: str) -> Array:
        body = self._data.body(name)
        return transform(body.xmat.reshape(3, 3).copy(), body.xpos.copy())

    def _fingers(self) -> Array:
        left, right = (self._data.geom(name).xpos for name in ("finger_left", "finger_right"))
        return transform(self._body("gripper_body")[:3, :3], (left + right) / 2)


@dataclass(frozen=True, slots=True)
class Conditions:
    """The conditions that differ between trials: the tracker's `method`, whether the tool's roll is locked, and more.

    `seed` decides everything that is random. `altered` names the parts that differ from those of a real site. Without
    a `network` both sites are on one host, and all pictures arrive as they are taken. With `assist` the cell has
    markers, and the operator lets the robot make the last part of the motion.
    """

    method: str
    roll_fixed: bool
    seed: int
    altered: tuple[Part, ...] = ()
    network: Network | None = None
    assist: bool = False


@dataclass(frozen=True, slots=True)
class TrialResult:
    """The outcome of a trial; `holds` counts how often the arm held by itself, `grip_force_n` is a finger's largest.

    `picture_age_ms` is the median age of the oldest view on the page, None without pictures.
    """

    end: Placed
    time_s: float
    drops: int
    collisions: int
    clutches: int
    misses: int
    holds: int
    grip_force_n: float
    picture_age_ms: float | None = None


def run_trial(conditions: Conditions) -> TrialResult:
    """Run a trial to its end; equal conditions give equal results."""
    rng = np.random.default_rng(conditions.seed)
    config = remote_config(rng)
    config = with_markers(config) if conditions.assist else config
    config = at_thesis_rate(config) if "thesis_rate" in conditions.altered else config
    site = SteppedSite(config, SteppedCell(config))
    judge = Judge(config, site.robot.cell)
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
        trial.seen.holds,
        judge.grip_force_n,
        float(np.median(trial.seen.ages_ms)) if trial.seen.ages_ms else None,
    )


@dataclass
class _Seen:
    """The counts of a running trial: how often the arm held by itself, and the ages of its oldest views."""

    holds: int = 0
    ages_ms: list[float] = field(default_factory=list)
    _held: bool = False

    def take(self, state: SessionState) -> None:
        """Take the session's state after a tick."""
        held = state is SessionState.HOLDING
        self.holds += held and not self._held
        self._held = held


class _Trial:
    """Operator, cameras, site and views, each at its own rate; what is under way between them."""

    def __init__(self, conditions: Conditions, config: RemoteConfig, site: SteppedSite[SteppedCell]) -> None:
        self._site, task, altered = site, PlacingTask(), conditions.altered
        true_sight = TrueSight(config, site) if "exact_sight" in altered else None
        network, rng = conditions.network or Network(), np.random.default_rng((conditions.seed, 1))
        views = StreamedViews(config, site.robot.memory, site.description, conditions.network, rng)
        self._views = true_sight or views
        self._markers = CellMarkers(config, site)
        views.see = self._markers.see
        see = true_sight.see if true_sight is not None else Sight(task).see
        hand = ScriptedHand(Motor(noise_m=0.0, noise_rad=0.0) if "exact_hand" in altered else Motor(), conditions.seed)
        mapping, locks = site.description.mapping, Locks(roll=conditions.roll_fixed)
        self.operator = VisualOperator(task, see, mapping, hand, locks, "unseen_turn" not in altered)
        self._arm = _operators_arm(conditions, hand)
        self._start_ns = site.now_ns
        self._exposures = Every(THESIS_NS if "thesis_rate" in altered else CAMERA_NS, site.now_ns)
        self._lag_s = THESIS_LAG_S if "thesis_rate" in altered else 0.0
        self._pages = Every(PAGE_NS, site.now_ns + PICTURE_NS)
        self._samples = Messages[HandArm](network, rng, LINK_NS)
        self._states = Messages[ShownPage](network, rng)
        self._states.send(self._state(), site.now_ns)
        self.seen = _Seen()

    @property
    def time_s(self) -> float:
        """The time that the trial has lasted."""
        return (self._site.now_ns - self._start_ns) / NS_PER_S

    def step(self) -> None:
        """Run one control period of the remote site."""
        now_ns = self._site.now_ns
        self._views.expose(now_ns)
        if self._exposures.due(now_ns):
            sent_ns = now_ns + TRACKING_NS
            sample = self._arm.sample(self._arm.see(now_ns, self._start_ns), self.operator.intent, sent_ns)
            self._samples.send(sample, sent_ns)
        self._states.arrived(now_ns)
        if self._pages.due(now_ns) and self._states.newest is not None:
            views = self._views.page(now_ns)
            if views:
                self.seen.ages_ms.append(max((now_ns - view.capture_ns) / NS_PER_MS for view in views.values()))
            self.operator.look(dataclasses.replace(self._states.newest, t_ns=now_ns, views=views), self._start_ns)
        samples = [NamedSample(OPERATOR, sample) for sample in self._samples.arrived(now_ns)]
        snapshot = self._site.tick(samples, self._markers.arrived())
        self._states.send(self._state(), self._site.now_ns)
        self.seen.take(snapshot.state)

    def _state(self) -> ShownPage:
        """Return what the site publishes now, for a page without views."""
        snapshot, gripper = self._site.snapshot, self._site.gripper
        return ShownPage(
            t_ns=self._site.now_ns,
            views={},
            state=snapshot.state,
            code=snapshot.reason.code.value,
            reason=snapshot.reason.sentence,
            opening_m=gripper.opening if gripper is not None else 0.0,
            gripper=gripper.status if gripper is not None else GripperStatus.UNKNOWN,
            delay_s=self._samples.takes_ns / NS_PER_S + self._lag_s,
            assist=snapshot.assist,
        )


def _operators_arm(conditions: Conditions, hand: ScriptedHand) -> TrackedOperator:
    filmed = SimulationConfig(motion=MotionConfig(still_s=0.0, wrist=WRIST_M), seed=conditions.seed)
    if conditions.method == "learned":
        filmed = replace(filmed, room=RoomConfig(scene="office", empty_s=EMPTY_S))
    filmed = replace(filmed, markers=conditions.method == "markers")
    altered, rng = conditions.altered, np.random.default_rng((conditions.seed, 2))
    return TrackedOperator(
        filmed,
        TrackingConfig(method=conditions.method),
        hand,
        exact="exact_tracker" in altered,
        smoothing=thesis_local().smoothing if "thesis_rate" in altered else None,
        alter=FingerErrors(rng).add if "thesis_fingers" in altered else None,
    )


def remote_config(rng: np.random.Generator) -> RemoteConfig:
    """Configure the cell with calibrated views and the block at a random start."""
    config = RemoteConfig().engaging(EngagementMode.HOLD_TO_RUN)
    # The share of the disc within a radius grows with its square, so the root of a uniform number spreads evenly.
    angle, radius = rng.uniform(0, 2 * np.pi), START_RADIUS_M * np.sqrt(rng.uniform())
    x, y = START_XY_M[0] + radius * np.cos(angle), START_XY_M[1] + radius * np.sin(angle)
    yaw_deg = float(rng.uniform(-START_TURN_DEG, START_TURN_DEG))
    block = replace(config.simulation.block, centre_xy_m=(float(x), float(y)), yaw_deg=yaw_deg)
    video = replace(config.video, calibrated=True, fps=NS_PER_S / PAGE_NS)
    return replace(config, video=video, simulation=replace(config.simulation, block=block))
