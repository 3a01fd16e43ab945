"""A mark on disk while the remote site runs: what ended without taking it away did not end in order."""

import os
import tempfile
from pathlib import Path


class CrashMarker:
    """The mark of one site, told apart by cell and port, in the service's state folder or else the user's run-time one.

    The first outlasts a power cut, the second does not: who starts a site by hand is there.
    """

    def __init__(self, cell: str, control_endpoint: str) -> None:
        folder = Path(os.environ.get("STATE_DIRECTORY") or os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
        port = control_endpoint.rpartition(":")[2]
        self._path = folder / f"farhand-{os.getuid()}-{cell}-{port}.running"

    def set(self) -> bool:
        """Set the mark so that no power cut can take it; True when one stood, so that the last run did not end well."""
        stood = self._path.exists()
        self._path.touch()
        _sync(self._path)
        _sync(self._path.parent)
        return stood

    def clear(self) -> None:
        """The site ends in order."""
        self._path.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
