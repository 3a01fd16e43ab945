"""A simulated cell on stepped time whose tool a path leads, through the whole remote site."""

from msgspec.structs import replace

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.hand import ClockSync, HandArm, Intent
from common.messages.robot import GripperCommand, LeaseState, Pose, RobotState, SessionState
from lab.stage.network.in_transit import InTransit
from lab.stage.stepped.robots import SteppedCell
from lab.stage.stepped.site import FOR_EVER_NS, LEASE, OPERATOR, SESSION, Every, SteppedSite
from local_site.programmed.path_progress import PathProgress
from local_site.programmed.path_runs import PathProgram, PathRuns
from local_site.samples.hand_sample import HandSampler, OpenHand
from remote_site.config import RemoteConfig
from remote_site.session.config import EngagementMode
from remote_site.session.samples import NamedSample
from tests.common.messages.golden_examples import STATE

LINK_NS, PERIOD_NS = 5 * NS_PER_MS, NS_PER_S // 60
CONFIG = RemoteConfig().engaging(EngagementMode.HOLD_TO_RUN)


class LedCell:
    """The cell, the runs on a path, the key that a person holds or not, and the link, which may be cut.

    The remote site's clock begins anew with each of its sessions, `remote` by number.
    """

    def __init__(
        self,
        progress: PathProgress,
        gripper_at_start: GripperCommand | None = None,
        *,
        goes_on: bool = True,
        config: RemoteConfig = CONFIG,
    ) -> None:
        self.site = SteppedSite(config, SteppedCell(config))
        self.progress = progress
        program = PathProgram(
            "taught", "a path", progress, gripper_at_start, goes_on, check=lambda _: None, orders=tuple
        )
        self.runs = PathRuns(program, SESSION, lambda: self.site.description)
        self.key_held, self.is_cut, self.reason = False, False, ""
        self._sampler, self._due = HandSampler(SESSION), Every(PERIOD_NS, self.site.now_ns)
        self._under_way = InTransit[HandArm]()
        self.remote, self._ended_ns = 1, 0

    def restart(self, config: RemoteConfig) -> None:
        """Start the remote site again, around the same arm, which its driver has stopped meanwhile."""
        self.site.clock.sleep_until_ns(self.site.now_ns + NS_PER_S)
        self._ended_ns += self.site.now_ns
        self.site = SteppedSite(config, self.site.robot)
        self._due, self._under_way = Every(PERIOD_NS, self.site.now_ns), InTransit()
        self.remote += 1

    def step(self) -> None:
        """One control period."""
        now_ns = self.site.now_ns
        if self._due.due(now_ns):
            local_ns = self._ended_ns + now_ns
            hand = self.runs.hand(local_ns, self.state())
            self.reason = hand.reason
            clock = ClockSync(remote_minus_local_ns=-self._ended_ns, uncertainty_ns=0, measured_ns=now_ns)
            intent, toggles = Intent(hold=self.key_held), OpenHand(toggles=self.runs.toggles)
            sample = self._sampler.sample(hand, toggles, LEASE, clock, intent, local_ns)
            if not self.is_cut:
                self._under_way.send(sample, now_ns + LINK_NS)
        self.site.tick([NamedSample(OPERATOR, sample) for sample in self._under_way.arrived(now_ns)])

    def pass_s(self, seconds: float) -> None:
        """Let time pass."""
        end_ns = self.site.now_ns + round(seconds * NS_PER_S)
        while self.site.now_ns < end_ns:
            self.step()

    def until(self, reason: str, most_s: float = 60.0) -> None:
        """Let time pass until the run says so."""
        end_ns = self.site.now_ns + round(most_s * NS_PER_S)
        while reason not in self.reason:
            assert self.site.now_ns < end_ns, f"no {reason!r}: {self.reason}"
            self.step()

    @property
    def base_T_tool(self) -> Array:
        """Where the tool truly is (4 x 4)."""
        return base_T_tool(self.site)

    def state(self) -> RobotState:
        """The robot's state as the site publishes it."""
        return robot_state(self.site, self.remote)


def base_T_tool(site: SteppedSite[SteppedCell]) -> Array:
    """Where the tool truly is (4 x 4)."""
    return site.model.forward(site.robot.q)


def robot_state(site: SteppedSite[SteppedCell], session: int = STATE.session) -> RobotState:
    """The robot's state as the site publishes it, as far as a run or its recording depends on it."""
    snapshot, follows = site.snapshot, site.snapshot.state is SessionState.ENGAGED
    return replace(
        STATE,
        session=session,
        t_ns=site.now_ns,
        state=snapshot.state,
        reason=snapshot.reason.sentence,
        base_T_tool=Pose.from_transform(base_T_tool(site)),
        gripper=site.gripper,
        gripper_toggles_applied=snapshot.gripper_toggles,
        gripper_next=snapshot.gripper_next,
        engagement=snapshot.engagement,
        lease=LeaseState(LEASE, OPERATOR, SESSION, FOR_EVER_NS, None),
        target=Pose.from_transform(snapshot.target) if follows else None,
        settings=snapshot.settings,
        readiness=replace(STATE.readiness, held=snapshot.held),
        reference=snapshot.reference if follows else None,
    )
