"""A marker file until the remote site ends in order: a start that finds one follows a failure, a crash or a kill."""

import os
import tempfile
from pathlib import Path


class CrashMarker:
    """The marker of one site, named by cell and port, in the service's state folder or else the user's run-time folder.

    The first survives a power cut; the second does not, but then a person has started the site by hand.
    """

    def __init__(self, cell: str, control_endpoint: str) -> None:
        folder = Path(os.environ.get("STATE_DIRECTORY") or os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
        port = control_endpoint.rpartition(":")[2]
        self._path = folder / f"farhand-{os.getuid()}-{cell}-{port}.running"

    def set(self) -> bool:
        """Create the marker on disk; True when one was there, so the last run did not end in order."""
        was_there = self._path.exists()
        self._path.touch()
        _sync(self._path)
        _sync(self._path.parent)
        return was_there

    def clear(self) -> None:
        """Remove the marker: the site ends in order."""
        self._path.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
