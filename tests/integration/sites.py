"""Both daemons as real processes on free endpoints, and everything received from them."""

import os
import signal
import tempfile
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.link.transport import open_link
from common.messages.robot import RobotState, SessionState
from farhand.loopback.recorder import Recorder
from farhand.loopback.site_process import SiteProcess, free_ports, module_command
from lab.stage.cell_endpoints import CellEndpoints
from lab.stage.staged_sites import StagedSites
from lab.stage.waiting import until
from tests.integration.systemd import Systemd

CELL = "test"
PATIENCE_S = 120.0
TOLD_LINES = 40
# Sites that leave a slow machine time for what is tested: none of this matters unless pace or accuracy is measured.
LIGHT_REMOTE = ("control.rate_hz=125", "video.fps=5", "video.width=160", "video.height=120")
# A busy machine makes the arm wait, and ends an engagement only where samples are a second late: see `was_late`.
PATIENT = ("safety.t_soft_ms=400", "safety.t_latch_ms=1000")
SMALL_PICTURES = {"width_px": 320, "height_px": 240, "focal_px": 400}
LIGHT_LOCAL = (
    "simulation.markers=true",
    "tracking.method=markers",
    "simulation.motion.name=figure_of_eight",
    "simulation.motion.begins=at_once",
    *(f"simulation.stereo.{key}={value}" for key, value in SMALL_PICTURES.items()),
)

running: list["Sites"] = []


class Sites:
    """The endpoints of one pair of sites, and the processes started on them, each under a systemd of its own."""

    def __init__(self) -> None:
        self.endpoints = CellEndpoints.on_ports(CELL, *free_ports(3))
        self.systemd: dict[int, Systemd] = {}
        self.stack = ExitStack()
        self._runtime = Path(self.stack.enter_context(tempfile.TemporaryDirectory()))
        self._staged = StagedSites({"STATE_DIRECTORY": str(self._runtime)})
        connect = self.endpoints.control, self.endpoints.listen
        self.link = self.stack.enter_context(open_link(connect=connect))
        self.record = Recorder(self.link, self.link, CELL, ()).record

    def remote(self, *settings: str, program: str = "farhand") -> SiteProcess:
        """Start a remote site; its states come a few seconds later."""
        return self.start("remote", *self.endpoints.remote, *LIGHT_REMOTE, *settings, program=program)

    def local(self, *settings: str, within: Sequence[str] = ()) -> SiteProcess:
        """Start a local site with a simulated operator, who wears markers; `within` is what begins its command."""
        return self.start("local", *self.endpoints.local, *LIGHT_LOCAL, *settings, within=within)

    def start(self, name: str, *settings: str, program: str = "farhand", within: Sequence[str] = ()) -> SiteProcess:
        """Start a process of this cell."""
        systemd = Systemd(self._runtime / f"notify-{len(self._staged.processes)}")
        self.stack.callback(systemd.close)
        with patch.dict(os.environ, NOTIFY_SOCKET=str(systemd.path)):
            process = self._staged.start(name, [*within, *module_command(program, name)], settings)
        self.systemd[process.pid] = systemd
        return process

    def wait_for_states(self) -> None:
        """Wait for the first state of a remote site."""
        self.wait("the remote site", lambda: bool(self.record.states))

    @property
    def state(self) -> RobotState:
        """The newest state."""
        return self.record.states[-1]

    def is_in(self, state: SessionState) -> bool:
        """Whether the newest state is this one."""
        return bool(self.record.states) and self.state.state is state

    def speed(self) -> float:
        """The fastest joint between the last two states, rad/s."""
        last, newest = self.record.states[-2:]
        seconds = (newest.t_ns - last.t_ns) / NS_PER_S
        return float(np.abs(np.subtract(newest.q, last.q)).max()) / seconds if seconds > 0 else 0.0

    def wait(self, what: str, is_so: Callable[[], bool], seconds: float = PATIENCE_S) -> None:
        """Wait until something is so; ProcessError with the state's reason otherwise."""
        until(is_so, what, seconds, lambda: [state.reason for state in self.record.states[-1:]])

    def said(self) -> str:
        """The last lines of every process's log."""
        tails = {p: list(p.lines.copy())[-TOLD_LINES:] for p in self._staged.processes}
        return "\n".join(f"{p.name} {p.pid} ({p.exit_code}): {line}" for p, tail in tails.items() for line in tail)

    def close(self) -> None:
        self._staged.end()
        self.stack.close()


@contextmanager
def running_sites() -> Iterator[Sites]:
    """Sites that end with the block."""
    sites = Sites()
    running.append(sites)
    try:
        yield sites
    finally:
        running.remove(sites)
        sites.close()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the log of all running sites to the report of a test that fails."""
    report = yield
    if report.failed:
        report.sections.append(("the sites", "\n".join(sites.said() for sites in running)))
    return report


def name_of(pid: int) -> str:
    """A process's name, as `ps` shows it; empty once there is none."""
    try:
        return Path(f"/proc/{pid}/comm").read_text().strip()
    except OSError:
        return ""


def child_of(process: SiteProcess, name: str) -> int:
    """The process of this name below a site."""
    return next(pid for pid in descendants(process.pid) if name_of(pid) == name)


def killed(local: SiteProcess, sites: Sites) -> RobotState:
    """The first state in which the arm is disengaged, once this local site has been killed."""
    seen = len(sites.record.states)
    os.kill(local.pid, signal.SIGKILL)
    sites.wait("its end", lambda: local.exit_code is not None)

    def disengaged() -> list[RobotState]:
        return [state for state in sites.record.states[seen:] if state.state is SessionState.DISENGAGED]

    sites.wait("the latch", lambda: bool(disengaged()))
    return disengaged()[0]


def descendants(pid: int) -> set[int]:
    """The processes that this one has started, and theirs."""
    parents: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except (OSError, ValueError):
                continue
    found = {pid}
    while more := {child for child, parent in parents.items() if parent in found} - found:
        found |= more
    return found - {pid}


def alive(pid: int) -> bool:
    """Whether a process exists and is no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
