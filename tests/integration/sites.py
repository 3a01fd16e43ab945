"""Both daemons as real processes on free endpoints, and everything heard of them."""

import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from common.messages import RobotState, SessionState
from common.transport import open_link
from farhand.loopback import free_ports
from farhand.recorder import Recorder
from farhand.site_process import SiteProcess

CELL = "test"
PATIENCE_S = 40.0
QUIET_VIDEO = "video.fps=5"


class Sites:
    """The endpoints of one pair of sites, and the processes started on them."""

    def __init__(self) -> None:
        self.control, self.video, self.listen = (f"tcp/127.0.0.1:{port}" for port in free_ports(3))
        self.processes: list[SiteProcess] = []
        self.stack = ExitStack()
        self.runtime = Path(self.stack.enter_context(tempfile.TemporaryDirectory()))
        link = self.stack.enter_context(open_link(connect=(self.control, self.listen)))
        self.link = link
        self.record = Recorder(link, link, CELL, ()).record

    def remote(self, *settings: str) -> SiteProcess:
        """Start a remote site and wait for its first state."""
        before = len(self.record.states)
        links = (f"links.control={self.control}", f"links.video={self.video}", QUIET_VIDEO)
        process = self.start("remote", *links, *settings)
        self.wait("the remote site", lambda: len(self.record.states) > before)
        return process

    def local(self, *settings: str) -> SiteProcess:
        """Start a local site with a simulated operator."""
        links = (f"links.remote={self.control}", f"links.listen={self.listen}")
        return self.start("local", *links, "simulation.motion.name=figure_of_eight", *settings)

    def start(self, name: str, *settings: str) -> SiteProcess:
        """Start a process of this cell."""
        arguments = [part for setting in (f"cell={CELL}", *settings) for part in ("--set", setting)]
        self.processes.append(SiteProcess(name, arguments, self.runtime))
        return self.processes[-1]

    @property
    def state(self) -> RobotState:
        """The newest state."""
        return self.record.states[-1]

    def is_in(self, state: SessionState) -> bool:
        """Whether the newest state is this one."""
        return bool(self.record.states) and self.state.state is state

    def wait(self, what: str, is_so: Callable[[], bool], seconds: float = PATIENCE_S) -> None:
        """Wait until something is so; an AssertionError with the last words of the sites otherwise."""
        deadline = time.monotonic() + seconds
        while not is_so():
            words = [f"{p.name}: {p.last_error()}" for p in self.processes]
            words += [state.reason for state in self.record.states[-1:]]
            assert time.monotonic() < deadline, f"waited in vain for {what}: {words}"
            time.sleep(0.02)

    def close(self) -> None:
        for process in reversed(self.processes):
            process.end()
        self.stack.close()


@contextmanager
def running_sites() -> Iterator[Sites]:
    """Sites that end with the block."""
    sites = Sites()
    try:
        yield sites
    finally:
        sites.close()


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
