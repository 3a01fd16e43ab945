"""A mark on disk while the remote site runs: what ended without taking it away did not end in order."""

import os
import tempfile
from pathlib import Path


class RunningMark:
    """The mark of one site, told apart by cell and port, in the user's run-time folder."""

    def __init__(self, cell: str, control_endpoint: str) -> None:
        folder = Path(os.environ.get("RUNTIME_DIRECTORY") or os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
        port = control_endpoint.rpartition(":")[2]
        self._path = folder / f"farhand-{os.getuid()}-{cell}-{port}.running"

    def set(self) -> bool:
        """Set the mark; True when one stood already, so that the last run was killed or failed."""
        stood = self._path.exists()
        self._path.touch()
        return stood

    def clear(self) -> None:
        """The site ends in order."""
        self._path.unlink(missing_ok=True)
