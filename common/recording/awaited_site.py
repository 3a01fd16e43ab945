"""Says in the log that a recorder waits for the site of its host, and that this site is there."""

import structlog


class AwaitedSite:
    """The site whose recorder this is: each change is one line."""

    def __init__(self, which: str, cell: str, endpoint: str) -> None:
        """`which` is remote or local, `endpoint` where it listens or meets others: a site elsewhere is another one."""
        self._which, self._facts = which, {"cell": cell, "endpoint": endpoint}
        self._is_there: bool | None = None

    def note(self, *, is_there: bool) -> None:
        """Note whether the site is there now, and log a change."""
        if is_there is self._is_there:
            return
        self._is_there = is_there
        log = structlog.get_logger()
        if is_there:
            log.info(f"the {self._which} site is there", **self._facts)
        else:
            cure = f"start 'farhand {self._which}' with the same configuration on this host"
            log.info(f"waiting for the {self._which} site: nothing of it comes yet", **self._facts, cure=cure)
