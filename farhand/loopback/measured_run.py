"""Both sites on this machine against a simulated operator and a simulated cell: started, watched, measured, ended."""

import json
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from common.clock import NS_PER_MS
from common.errors import ConfigError, InterruptionError, ProcessError
from common.geometry import Array
from common.link.channels import ChannelSession
from common.link.transport import open_link
from common.messages.robot import FOLLOWING, Engagement
from common.process.service import StopFlag
from farhand.loopback.display import LiveSummary, print_table, save_camera_views, save_overview
from farhand.loopback.figures import Expectation, Figures, all_figures, session_events
from farhand.loopback.plan import LoopbackOptions, plan_of
from farhand.loopback.recorded import read_run, recording_figures
from farhand.loopback.recorder import Record, Recorder
from farhand.loopback.running_sites import RunningSites
from farhand.loopback.scenario import operator_views
from farhand.loopback.site_process import listens, start_site
from farhand.loopback.verdict import check_followed, explained, judged_failure, praise, slow_views, too_slow
from farhand.outputs import check_file, check_folder, check_new_file
from farhand.terminal import aside, tell
from farhand.tracking.track_run import prepare_tracker
from local_site.acquisition.simulated_cameras import Beginning
from local_site.simulation.operator import Operator as SimulatedOperator
from local_site.simulation.operator import make_operator
from remote_site.config import RemoteConfig

START_TIMEOUT_S = 90.0  # longer than a site waits for its own processes, which it then names
ENGAGE_TIMEOUT_S = 60.0  # on a machine that does much else the tracker alone takes a quarter of a minute to start
SETTLE_NS = 400 * NS_PER_MS  # from the opening of the hand to the toggled gripper, with room
SETTLE_TIMEOUT_S = 3.0
POLL_S = 0.05
READY = "event=ready"

ShowPage = Callable[[str], str]


@dataclass(frozen=True, slots=True)
class LoopbackOperator:
    """The operator that the local site simulates, also here for the ground truth."""

    simulated: SimulatedOperator
    beginning: Beginning

    def truth(self, t_ns: int) -> Mapping[str, Array]:
        """The true points at a time."""
        return self.simulated.points(self.beginning.elapsed_s(t_ns))

    def openings(self, t_ns: int) -> int:
        """Count how often the hand has begun to open by a time."""
        return self.simulated.openings_until(self.beginning.elapsed_s(t_ns))


class Loopback:
    """One run from the start of both sites to its figures; `shows` opens the page, or says why it cannot."""

    def __init__(self, options: LoopbackOptions, should_stop: StopFlag, shows: ShowPage = lambda _: "") -> None:
        self._options, self._shows = options, shows
        self._should_stop = should_stop
        self._plan = plan_of(options)
        self._remote, self._local = self._plan.remote.load(), self._plan.local.load()
        self.operator_views = operator_views(self._local.tracking.method)
        self._operator = LoopbackOperator(make_operator(self._local.simulation), Beginning())
        self._sites = RunningSites()
        self.failure: ProcessError | None = None

    @property
    def views_are_simulated(self) -> bool:
        """Return whether the remote site renders its views."""
        return self._remote.views_are_simulated

    @property
    def record(self) -> Record:
        """Everything received from the sites."""
        return self._sites.record

    def run(self) -> Figures:
        """Start, wait for the arm to follow, measure, end; ProcessError states what went wrong before it followed.

        What goes wrong after that ends the run, and is the `failure` beside the figures of what was measured.
        """
        prepare_tracker(self._local.tracking)
        with ExitStack() as stack, LiveSummary(self._options.seconds) as live:
            for note in self._plan.notes:
                live.print(note)
            runtime = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="farhand-")))
            stack.callback(self._sites.end)
            if self._options.record is not None:
                self._start_recorder(self._options.record, runtime)
            self._start_remote(runtime, stack)
            views = self._options.save_views
            saving = ["--save-views", str(views.resolve())] if views else []
            self._sites.add(start_site("local", [*self._plan.local.arguments, *saving], runtime))
            if not self._options.headless:
                self._start_console(runtime, live)
            self._wait("the arm to be engaged", ENGAGE_TIMEOUT_S, lambda: self._engagement is not None)
            if self._engagement is not None:
                self._operator.beginning.set(self._engagement.hand_capture_ns)
            try:
                self._watch(live)
                self._settle()
            except ProcessError as failure:
                self.failure = failure
        figures = run_figures(self.record, self._operator, self._remote, self._sites.events)
        figures["too_slow"] = self.slowness()
        figures["slow_views"] = slow_views(figures["video"], self._remote.video.fps)
        if self._options.record is not None:
            figures["recording"] = self._recomputed(self._options.record, figures)
        return figures

    def slowness(self) -> str | None:
        """Say why this machine was too slow for the run, None where it was not; once the sites have ended."""
        return too_slow(self.record, self._local.simulation.fps, self._sites.events)

    def _recomputed(self, path: Path, printed: Figures) -> Figures:
        """Read the run's recording, and compare the figures that it gives."""
        run = read_run(path, self._remote.cell, self.record)
        return recording_figures(
            path, run, printed, lambda record: run_figures(record, self._operator, self._remote, [])
        )

    def _start_recorder(self, file: Path, runtime: Path) -> None:
        """Before the site, so that not even its first control cycle is missed."""
        arguments = [*self._plan.remote.arguments, "--file", str(file)]
        recorder = self._sites.add(start_site("record", arguments, runtime))
        self._wait("the recorder", START_TIMEOUT_S, lambda: any(READY in line for line in list(recorder.lines)))

    def _start_remote(self, runtime: Path, stack: ExitStack) -> None:
        remote = self._remote
        self._sites.add(start_site("remote", self._plan.remote.arguments, runtime))
        control = stack.enter_context(open_link(connect=(remote.links.control, self._local.links.listen)))
        video = stack.enter_context(open_link(connect=(remote.links.video,), sessions=[ChannelSession.VIDEO]))
        cameras = tuple(camera.name for camera in remote.video.cameras)
        self._sites.listen(Recorder(control, video, remote.cell, cameras))
        self._wait("the remote site to start", START_TIMEOUT_S, lambda: bool(self.record.states))
        if self._options.record is not None:
            self._wait("a recording", START_TIMEOUT_S, self._is_recorded)
        if self._should_stop():
            raise InterruptionError("interrupted before both sites were up; nothing was measured")

    def _is_recorded(self) -> bool:
        recording = self.record.states[-1].recording if self.record.states else None
        if recording is not None and recording.alarm:
            raise ProcessError(recording.alarm)
        return recording is not None and recording.writing

    def _start_console(self, runtime: Path, live: LiveSummary) -> None:
        port = self._plan.console.load().serve.port
        self._sites.add(start_site("console", self._plan.console.arguments, runtime))
        self._wait("the operator's page", START_TIMEOUT_S, lambda: listens(port))
        url = f"http://127.0.0.1:{port}/"
        live.print(f"the operator's page: {url}")
        if instead := self._shows(url):
            live.print(instead)

    @property
    def _engagement(self) -> Engagement | None:
        """The first, at which the operator begins to move."""
        return next((s.engagement for s in list(self.record.states) if s.engagement is not None), None)

    def _wait(self, what: str, timeout_s: float, is_so: Callable[[], bool]) -> None:
        deadline = time.monotonic() + timeout_s
        while not is_so() and not self._should_stop():
            self._sites.check()
            if time.monotonic() > deadline:
                raise ProcessError(f"waited {timeout_s:g} s without success for {what}: {self._sites.last_errors()}")
            time.sleep(POLL_S)

    def _watch(self, live: LiveSummary) -> None:
        start = time.monotonic()
        while not self._should_stop():
            elapsed = time.monotonic() - start
            if self._options.seconds and elapsed >= self._options.seconds:
                return
            self._sites.check()
            self._sites.check_silence()
            live.show(elapsed, self.record)
            self._should_stop.wait(POLL_S)

    def _settle(self) -> None:
        """Let an opening of the hand that has just begun reach the gripper."""
        deadline = time.monotonic() + SETTLE_TIMEOUT_S
        while not self._should_stop() and time.monotonic() < deadline:
            now_ns = time.monotonic_ns()
            if self._operator.openings(now_ns) == self._operator.openings(now_ns - SETTLE_NS):
                return
            time.sleep(POLL_S)


def run_figures(record: Record, operator: LoopbackOperator, remote: RemoteConfig, warnings: list[str]) -> Figures:
    """The report of a run: what was measured, how it ended, and what the sites warned of."""
    mapping, states = remote.mapping, record.states
    last = states[-1] if states else None
    expectation = Expectation(mapping.scale, np.array(mapping.base_R_operator), mapping.point)
    return {
        **all_figures(record, operator.truth, expectation),
        "toggles": {
            "sent": operator.openings(last.t_ns) if last else 0,
            "applied": last.gripper_toggles_applied if last else 0,
        },
        "stopped": last.reason if last and last.state not in FOLLOWING else None,
        "rejected": last.rejected if last else {},
        "events": session_events(states) + warnings,
    }


def run_loopback(
    options: LoopbackOptions, should_stop: StopFlag, *, as_json: bool = False, shows: ShowPage = lambda _: ""
) -> None:
    """Run, print, write report and views; ProcessError when a site dies or the arm does not follow.

    The figures are printed, as a table or as JSON, once the arm has followed, also where a site has died since. The
    last line says whether all is good, this machine was too slow (for what), or something is broken.
    InterruptionError, with what was measured printed and written, when a person ended a run before its time.
    """
    if options.report is not None:
        check_file("--report", options.report)
    check_folder("--save-views", options.save_views)
    if options.record is not None:
        check_new_file("--record", options.record)
    loop = Loopback(options, should_stop, shows)
    try:
        figures = loop.run()
    except ProcessError as error:
        failure = explained(error, views_are_simulated=loop.views_are_simulated)
        raise judged_failure(failure, loop.slowness() if failure is error else None) from error
    if as_json:
        tell((), figures, as_json=True)
    else:
        print_table(figures, Console())
    if options.report is not None:
        write_report(options.report, figures)
    if options.save_views is not None:
        save_camera_views(loop.record.cameras, options.save_views)
        save_overview((*loop.record.cameras, *loop.operator_views), options.save_views)
    if loop.failure is not None:
        raise judged_failure(loop.failure, figures["too_slow"]) from loop.failure
    if should_stop() and (options.seconds or not figures["engagements"]):
        raise InterruptionError("interrupted")
    try:
        check_followed(figures)
    except ProcessError as error:
        raise judged_failure(error, figures["too_slow"]) from error
    aside(as_json=as_json)(figures["too_slow"] or praise(figures))


def write_report(path: Path, figures: Figures) -> None:
    """Write all figures as JSON, also to a device or through a link; ConfigError when that fails."""
    try:
        path.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"cannot write --report {path}: {error.strerror}; choose another file") from error
