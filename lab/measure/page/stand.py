"""Both sites and a console as processes, for end-to-end measurements of the page."""

import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from common.errors import ProcessError
from common.link.transport import open_link
from farhand.loopback.recorder import Record, Recorder
from farhand.loopback.site_process import SiteProcess, free_ports, listens, start_site

CELL = "bench"
PATIENCE_S = 120.0


def wait(what: str, is_so: Callable[[], bool]) -> None:
    """Wait until a condition holds; ProcessError when it does not within PATIENCE_S."""
    deadline = time.monotonic() + PATIENCE_S
    while not is_so():
        if time.monotonic() > deadline:
            raise ProcessError(f"timed out waiting for {what}")
        time.sleep(0.05)


class PageStand:
    """A remote site with the simulated cell, and a record of its messages; it streams at `video_port`."""

    def __init__(self, stack: ExitStack, *settings: str) -> None:
        control, self.video_port, local = free_ports(3)
        self._control, self._local = f"tcp/127.0.0.1:{control}", f"tcp/127.0.0.1:{local}"
        self._runtime = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        self._stack = stack
        video = f"tcp/127.0.0.1:{self.video_port}"
        remote = (f"links.control={self._control}", f"links.video={video}", *settings)
        self.remote = self._start("remote", *remote, program="lab.stage.stand_ins.clocked_views")
        link = stack.enter_context(open_link(connect=(self._control,)))
        self.record: Record = Recorder(link, link, CELL, ()).record
        wait("the remote site", lambda: bool(self.record.states))

    def follow(self) -> SiteProcess:
        """Start a local site whose simulated hand the arm follows, and wait for its lease."""
        process = self._start(
            "local",
            f"links.remote={self._control}",
            f"links.listen={self._local}",
            "simulation.motion.name=figure_of_eight",
            "simulation.motion.begins=at_once",
        )
        wait("the lease", lambda: self.record.states[-1].lease is not None)
        return process

    def console(self, video_port: int) -> tuple[SiteProcess, str]:
        """Start a console that takes its pictures from this port; its page's address."""
        port = free_ports(1)[0]
        process = self._start(
            "console",
            f"links.control={self._control}",
            f"links.video=tcp/127.0.0.1:{video_port}",
            f"links.local={self._local}",
            f"serve.port={port}",
        )
        wait("the page", lambda: process.exit_code is not None or listens(port))
        return process, f"http://127.0.0.1:{port}/"

    def _start(self, name: str, *settings: str, program: str = "farhand") -> SiteProcess:
        arguments = [part for setting in (f"cell={CELL}", *settings) for part in ("--set", setting)]
        process = start_site(name, arguments, self._runtime, program)
        self._stack.callback(process.end)
        return process
