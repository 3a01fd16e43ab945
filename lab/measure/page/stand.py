"""Both sites and a console as processes, for end-to-end measurements of the page."""

import tempfile
from collections.abc import Callable
from contextlib import ExitStack

from common.link.transport import open_link
from farhand.loopback.recorder import Recorder
from farhand.loopback.site_process import SiteProcess, free_ports, listens, module_command
from lab.stage.cell_endpoints import CellEndpoints
from lab.stage.staged_sites import StagedSites

CELL = "bench"
PATIENCE_S = 120.0
AS_LOOPBACK = ("video.calibrated=true", "engagement.mode=automatic")  # the arm follows, with all that is drawn over it


class PageStand:
    """A remote site with the simulated cell, and a record of its messages; it streams at `video_port`."""

    def __init__(self, stack: ExitStack, *settings: str) -> None:
        control, self.video_port, listen = free_ports(3)
        self._endpoints = CellEndpoints.on_ports(CELL, control, self.video_port, listen)
        self._sites = StagedSites({"STATE_DIRECTORY": stack.enter_context(tempfile.TemporaryDirectory())})
        stack.callback(self._sites.end)
        clocked = module_command("lab.stage.stand_ins.clocked_views", "remote")
        self.remote = self._sites.start("remote", clocked, (*self._endpoints.remote, *settings))
        link = stack.enter_context(open_link(connect=(self._endpoints.control,)))
        self._sites.listen(Recorder(link, link, CELL, ()))
        self.record = self._sites.record
        self.wait("the remote site", lambda: self.record.states)

    def follow(self, *settings: str) -> SiteProcess:
        """Start a local site whose simulated hand the arm may follow, and wait for its lease."""
        motion = "simulation.motion.name=figure_of_eight", "simulation.motion.begins=at_once"
        process = self._start("local", *self._endpoints.local, *motion, *settings)
        self.wait("the lease", lambda: self.record.states[-1].lease is not None)
        return process

    def console(self, video_port: int) -> tuple[SiteProcess, str]:
        """Start a console that takes its pictures from this port; its page's address."""
        port = free_ports(1)[0]
        video = f"links.video=tcp/127.0.0.1:{video_port}"
        process = self._start("console", *self._endpoints.console, video, f"serve.port={port}")
        self.wait("the page", lambda: listens(port))
        return process, f"http://127.0.0.1:{port}/"

    def wait(self, what: str, is_so: Callable[[], object]) -> None:
        """Wait until something is so; ProcessError when it is not within PATIENCE_S, or a site has ended."""
        self._sites.wait(what, is_so, PATIENCE_S)

    def _start(self, name: str, *settings: str) -> SiteProcess:
        return self._sites.start(name, module_command("farhand", name), settings)
