"""Both sites on this machine against a simulated operator and a simulated cell: started, watched, measured, ended."""

import json
import socket
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from common.clock import NS_PER_MS, NS_PER_S
from common.config import load_config
from common.errors import InterruptionError, ProcessError
from common.geometry import Array
from common.link.channels import ChannelSession
from common.link.transport import open_link
from common.messages.robot import Engagement, SessionState
from common.process.service import StopFlag
from farhand.loopback.casting import (
    A465,
    ARM_FILES,
    USUAL_MOTION,
    arm_settings,
    check_cast,
    operator_settings,
    operator_views,
)
from farhand.loopback.figures import (
    Expectation,
    Figures,
    all_figures,
    session_events,
)
from farhand.loopback.live import LiveSummary, print_table
from farhand.loopback.recorder import Record, Recorder
from farhand.loopback.site_process import SiteProcess
from farhand.loopback.views import save_camera_views, save_overview
from farhand.outputs import check_file, check_folder
from farhand.preparing import prepare_tracker
from local_site.config import LocalConfig
from local_site.simulation.beginning import Beginning
from local_site.simulation.operators import Operator as SimulatedOperator
from local_site.simulation.operators import make_operator
from remote_site.config import RemoteConfig
from remote_site.drivers.config import EMULATED
from remote_site.drivers.registry import check_driver

CELL = "loopback"
START_TIMEOUT_S = 40.0
ENGAGE_TIMEOUT_S = 60.0  # on a machine that does much else the tracker alone takes a quarter of a minute to start
SILENT_NS = 2 * NS_PER_S
SETTLE_NS = 400 * NS_PER_MS  # from the opening of the hand to the toggled gripper, with room
SETTLE_TIMEOUT_S = 3.0
POLL_S = 0.05
MAX_FOLLOW_MM = 50.0
FOLLOWING = (SessionState.ENGAGED, SessionState.HOLDING)


@dataclass(frozen=True, slots=True)
class LoopbackOptions:
    """What the command line asks for."""

    seconds: float = 30.0
    report: Path | None = None
    driver: str = "simulated"
    motion: str = USUAL_MOTION
    tracker: str = "silhouette"
    arm: str = A465
    save_views: Path | None = None
    headless: bool = False
    remote_settings: tuple[str, ...] = ()
    local_settings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class LoopbackOperator:
    """The operator that the local site simulates, known here too for the truth."""

    simulated: SimulatedOperator
    beginning: Beginning

    def truth(self, t_ns: int) -> Mapping[str, Array]:
        """The true points at a time."""
        return self.simulated.points(self.beginning.elapsed_s(t_ns))

    def openings(self, t_ns: int) -> int:
        """How often the hand has begun to open by a time."""
        return self.simulated.openings_until(self.beginning.elapsed_s(t_ns))


@dataclass(frozen=True, slots=True)
class Plan:
    """The settings of both sites and the console, where to listen to the sites, and where the page is.

    `arm` is the remote site's file, None for its defaults.
    """

    arm: Path | None
    remote: tuple[str, ...]
    local: tuple[str, ...]
    console: tuple[str, ...]
    page_port: int
    control: tuple[str, ...]
    video: tuple[str, ...]


def plan_of(options: LoopbackOptions) -> Plan:
    """Settings with free endpoints of this host; ConfigError when the options ask for what there is not."""
    check_cast(options.tracker, options.arm, options.motion, options.driver)
    *ports, page = free_ports(4)
    control, video, local = (f"tcp/127.0.0.1:{port}" for port in ports)
    remote_settings = (
        f"links.control={control}",
        f"links.video={video}",
        "video.calibrated=true",
        f"driver.name={options.driver}",
        f"driver.emulate={str(options.driver == EMULATED).lower()}",
        *arm_settings(options.tracker),
    )
    local_settings = (
        f"links.remote={control}",
        f"links.listen={local}",
        *operator_settings(options.tracker, options.motion),
    )
    plan = Plan(
        arm=ARM_FILES[options.arm],
        remote=(f"cell={CELL}", *remote_settings, *options.remote_settings),
        local=(f"cell={CELL}", *local_settings, *options.local_settings),
        console=(
            f"cell={CELL}",
            f"links.control={control}",
            f"links.video={video}",
            f"links.local={local}",
            f"serve.port={page}",
        ),
        page_port=page,
        control=(control, local),
        video=(video,),
    )
    load_config(LocalConfig, None, plan.local)
    check_driver(load_config(RemoteConfig, plan.arm, plan.remote).driver.name)
    return plan


class Loopback:
    """One run: the two sites, and everything heard of them."""

    def __init__(self, options: LoopbackOptions, should_stop: StopFlag) -> None:
        self._options = options
        self._should_stop = should_stop
        self._plan = plan_of(options)
        self._runtime = Path()
        self._sites: list[SiteProcess] = []
        self._events: list[str] = []
        self.record = Record()

    def run(self) -> Figures:
        """Start, wait for the arm to follow, measure, end; ProcessError says what went wrong."""
        remote = load_config(RemoteConfig, self._plan.arm, self._plan.remote)
        prepare_tracker(load_config(LocalConfig, None, self._plan.local).tracking)
        with ExitStack() as stack, LiveSummary(self._options.seconds) as live:
            self._runtime = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="farhand-")))
            stack.callback(self._end)
            self._start("remote", self._plan.remote, ["--config", str(self._plan.arm)] if self._plan.arm else [])
            control = stack.enter_context(open_link(connect=self._plan.control))
            video = stack.enter_context(open_link(connect=self._plan.video, sessions=[ChannelSession.VIDEO]))
            self.record = Recorder(control, video, CELL, tuple(c.name for c in remote.video.cameras)).record
            self._wait("the remote site to start", START_TIMEOUT_S, lambda: bool(self.record.states))
            if self._should_stop():
                raise InterruptionError("interrupted before both sites were up; nothing was measured")
            operator = self._start_local()
            if not self._options.headless:
                self._start("console", self._plan.console)
                self._wait("the operator's page", START_TIMEOUT_S, lambda: listens(self._plan.page_port))
                live.say(f"the operator's page: http://127.0.0.1:{self._plan.page_port}/")
            self._wait("the arm to be engaged", ENGAGE_TIMEOUT_S, lambda: self._engagement is not None)
            if self._engagement is not None:
                operator.beginning.set(self._engagement.hand_capture_ns)
            self._watch(live)
            self._settle(operator)
        return self._figures(operator, remote)

    def _start(self, name: str, settings: Sequence[str], extra: Sequence[str] = ()) -> None:
        arguments = [part for setting in settings for part in ("--set", setting)]
        self._sites.append(SiteProcess(name, [*arguments, *extra], self._runtime))

    def _start_local(self) -> LoopbackOperator:
        views = self._options.save_views
        self._start("local", self._plan.local, ["--save-views", str(views.resolve())] if views else [])
        local = load_config(LocalConfig, None, self._plan.local)
        return LoopbackOperator(make_operator(local.simulation), Beginning())

    @property
    def _engagement(self) -> Engagement | None:
        """The first, at which the operator begins to move."""
        return next((s.engagement for s in list(self.record.states) if s.engagement is not None), None)

    def _wait(self, what: str, timeout_s: float, is_so: Callable[[], bool]) -> None:
        deadline = time.monotonic() + timeout_s
        while not is_so() and not self._should_stop():
            self._check_sites()
            if time.monotonic() > deadline:
                raise ProcessError(f"waited {timeout_s:g} s in vain for {what}: {self._last_word()}")
            time.sleep(POLL_S)

    def _watch(self, live: LiveSummary) -> None:
        start = time.monotonic()
        while not self._should_stop():
            elapsed = time.monotonic() - start
            if self._options.seconds and elapsed >= self._options.seconds:
                return
            self._check_sites()
            self._check_silence()
            live.show(elapsed, self.record)
            self._should_stop.wait(POLL_S)

    def _settle(self, operator: LoopbackOperator) -> None:
        """Let an opening of the hand that has just begun reach the gripper."""
        deadline = time.monotonic() + SETTLE_TIMEOUT_S
        while not self._should_stop() and time.monotonic() < deadline:
            now_ns = time.monotonic_ns()
            if operator.openings(now_ns) == operator.openings(now_ns - SETTLE_NS):
                return
            time.sleep(POLL_S)

    def _check_sites(self) -> None:
        for site in self._sites:
            if site.exit_code is not None:
                raise ProcessError(f"the {site.name} site died (exit code {site.exit_code}): {site.last_error()}")

    def _check_silence(self) -> None:
        now_ns = time.monotonic_ns()
        for name, heard_ns in (("local", self.record.last_hand_ns), ("remote", self.record.last_state_ns)):
            if now_ns - heard_ns > SILENT_NS:
                raise ProcessError(f"the {name} site has been silent for 2 s: {self._last_word()}")

    def _last_word(self) -> str:
        words = [site.last_error() for site in self._sites]
        if self.record.states:
            words.insert(0, self.record.states[-1].reason)
        return "; ".join(words)

    def _end(self) -> None:
        for site in reversed(self._sites):
            site.end()
            self._events += site.events

    def _figures(self, operator: LoopbackOperator, remote: RemoteConfig) -> Figures:
        expectation = Expectation(remote.mapping.scale, np.array(remote.mapping.base_R_operator), remote.mapping.point)
        figures = all_figures(self.record, operator.truth, expectation)
        states = self.record.states
        figures["toggles"] = {
            "sent": operator.openings(states[-1].t_ns) if states else 0,
            "applied": states[-1].gripper_toggles_applied if states else 0,
        }
        last = states[-1] if states else None
        figures["stopped"] = last.reason if last is not None and last.state not in FOLLOWING else None
        figures["rejected"] = states[-1].rejected if states else {}
        figures["events"] = session_events(states) + self._events
        return figures


def free_ports(count: int) -> list[int]:
    """Ports of the loopback interface that nobody listens on now."""
    with ExitStack() as stack:
        probes = [stack.enter_context(socket.socket()) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [int(probe.getsockname()[1]) for probe in probes]


def listens(port: int) -> bool:
    """Whether somebody listens on a port of the loopback interface."""
    with socket.socket() as probe:
        probe.settimeout(POLL_S)
        return probe.connect_ex(("127.0.0.1", port)) == 0


def run_loopback(options: LoopbackOptions, should_stop: StopFlag) -> None:
    """Run, print the table, write report and views; ProcessError when a site dies or the arm does not follow.

    InterruptionError, with what was measured printed and written, when a person ended a run before its time.
    """
    if options.report is not None:
        check_file("--report", options.report)
    check_folder("--save-views", options.save_views)
    loop = Loopback(options, should_stop)
    figures = loop.run()
    print_table(figures, Console())
    if options.report is not None:
        options.report.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    if options.save_views is not None:
        save_camera_views(loop.record.cameras, options.save_views)
        save_overview((*loop.record.cameras, *operator_views(options.tracker)), options.save_views)
    if should_stop() and (options.seconds or not figures["engagements"]):
        raise InterruptionError("interrupted")
    check_followed(figures)


def check_followed(figures: Figures) -> None:
    """ProcessError when the tool did not follow the hand, or stopped following it."""
    if figures["stopped"] is not None:
        raise ProcessError(
            f"the arm followed for {figures['followed_share']:.0%} of the time, then: {figures['stopped']}"
        )
    mean = figures["follow_mm"]["mean"]
    if mean is None:
        raise ProcessError("the arm was never engaged")
    if mean > MAX_FOLLOW_MM:
        raise ProcessError(f"the arm does not follow: its tool is {mean:.0f} mm off on average")
