"""The sites on a stage: each program started with its settings, awaited, ended alone or with all others."""

from collections.abc import Callable, Iterable, Mapping, Sequence

from farhand.loopback.running_sites import RunningSites
from farhand.loopback.site_process import SiteProcess, options_of
from lab.stage.waiting import until


class StagedSites(RunningSites):
    """The programs of one cell; all that it has started ends with it, and nothing else does."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        """`environment` is what each program has beyond this one's."""
        super().__init__()
        self._environment = environment

    def start(self, name: str, command: Sequence[str], settings: Iterable[str] = ()) -> SiteProcess:
        """Start a program with these settings."""
        return self.add(SiteProcess(name, [*command, *options_of(settings)], self._environment))

    def named(self, name: str) -> SiteProcess:
        """The newest program of this name; KeyError before one has been started."""
        return {process.name: process for process in self.processes}[name]

    def end_named(self, name: str) -> None:
        """End the programs of this name, where there are any, and keep their warnings."""
        for process in [each for each in self.processes if each.name == name]:
            process.end()
            self.events += process.events
            self.processes.remove(process)

    def wait(self, what: str, is_so: Callable[[], object], seconds: float) -> None:
        """Wait until something is so; ProcessError where that takes longer, or a program ends meanwhile."""

        def is_so_yet() -> bool:
            if is_so():
                return True
            self.check()
            return False

        until(is_so_yet, what, seconds, self.last_errors)
