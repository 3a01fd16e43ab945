"""The processes of a cell's sites and what is received from them: watched while they run, ended in order."""

import time

from common.clock import NS_PER_S
from common.errors import ProcessError
from farhand.loopback.figures import troubles
from farhand.loopback.recorder import Record, Recorder
from farhand.loopback.site_process import SiteProcess

SILENT_NS = 2 * NS_PER_S


class RunningSites:
    """The processes of a run and everything received from them."""

    def __init__(self) -> None:
        self.record = Record()
        self.events: list[str] = []
        self.processes: list[SiteProcess] = []
        self._recorder: Recorder | None = None

    def add(self, site: SiteProcess) -> SiteProcess:
        """Take a process that is started already."""
        self.processes.append(site)
        return site

    def listen(self, recorder: Recorder) -> None:
        """Keep what this records of the sites."""
        self._recorder, self.record = recorder, recorder.record

    def check(self) -> None:
        """ProcessError, with its last error, when a process has ended."""
        for site in self.processes:
            if site.exit_code is not None:
                raise ProcessError(f"the {site.name} process ended (exit code {site.exit_code}): {site.last_error()}")

    def check_silence(self) -> None:
        """ProcessError when a site has sent nothing for two seconds."""
        now_ns = time.monotonic_ns()
        for name, received_ns in (("local", self.record.last_hand_ns), ("remote", self.record.last_state_ns)):
            if now_ns - received_ns > SILENT_NS:
                raise ProcessError(f"the {name} site has been silent for 2 s: {self.last_errors()}")

    def last_errors(self) -> str:
        """Say what is wrong by the states of the last seconds, and the last error or line of each process."""
        errors = (f"{site.name}: {site.last_error()}" for site in self.processes)
        return "; ".join([*troubles(list(self.record.states)), *errors])

    def end(self) -> None:
        """End the processes, the last one first, and keep their warnings; the links are closed by then."""
        if self._recorder is not None:
            self._recorder.join()
        for site in reversed(self.processes):
            site.end()
            self.events += site.events
