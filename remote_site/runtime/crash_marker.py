"""A marker file until the remote site ends in order: a start that finds one follows a failure, a crash or a kill."""

import fcntl
import os
from pathlib import Path

from common.errors import ConfigError

STATE_HOME = "~/.local/state"  # where XDG_STATE_HOME is not set
OPENING = os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK  # others may have put a link or a pipe there

CURE = "set STATE_DIRECTORY to a folder of this user's own that survives a power cut"


class CrashMarker:
    """The marker of one run in its cell's folder, in the service's state folder or else the user's.

    Both survive a power cut. The process holds a lock on its marker, so that another site of the same cell on this
    machine is not taken for a run that has ended. In a state folder that others share, no link of theirs is followed.
    """

    def __init__(self, cell: str) -> None:
        self._folder = _state_folder() / "unfinished" / cell
        self._own = self._folder / str(os.getpid())
        self._left: list[Path] = []
        self._locked: int | None = None

    def set(self) -> bool:
        """Create the marker on disk; True when another run has left one, so that it did not end in order.

        ConfigError where the folder cannot be written, or is another's.
        """
        try:
            self._folder.parent.parent.mkdir(parents=True, exist_ok=True)
            for folder in (self._folder.parent, self._folder):
                _make_own(folder)
            _check_link(self._own)
            self._left = [path for path in self._folder.iterdir() if _is_left(path)]
            self._locked = os.open(self._own, OPENING | os.O_CREAT, 0o600)
        except OSError as error:
            raise ConfigError(
                f"no crash marker can be kept in {self._folder}: {error.strerror}; make the folder writable, or {CURE}"
            ) from error
        fcntl.lockf(self._locked, fcntl.LOCK_EX)  # this process's alone, and not its children's
        os.fsync(self._locked)
        _sync(self._folder)
        return bool(self._left)

    def clear(self) -> None:
        """Remove the marker and those that other runs have left: the site ends in order."""
        for path in (*self._left, self._own):
            path.unlink(missing_ok=True)
        if self._locked is not None:
            os.close(self._locked)
            self._locked = None


def _state_folder() -> Path:
    service = os.environ.get("STATE_DIRECTORY")
    return Path(service) if service else Path(os.environ.get("XDG_STATE_HOME") or STATE_HOME).expanduser() / "farhand"


def _make_own(folder: Path) -> None:
    """Make a folder, unless there is one; ConfigError where its markers would be in another user's hands."""
    _check_link(folder)
    folder.mkdir(mode=0o700, exist_ok=True)
    if folder.lstat().st_uid != os.geteuid():
        raise ConfigError(f"{folder} belongs to another user; {CURE}")


def _check_link(path: Path) -> None:
    """ConfigError for a symbolic link, which may lead into the files of others."""
    if path.is_symlink():
        raise ConfigError(f"{path} is a symbolic link, where a crash marker is to be kept; {CURE}")


def _is_left(path: Path) -> bool:
    """Return whether the run of this marker has ended, and not in order; what is no marker counts as one."""
    try:
        marker = os.open(path, OPENING)
    except FileNotFoundError:  # it has just ended in order
        return False
    except OSError:
        return True
    try:
        fcntl.lockf(marker, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:  # it lives
        return False
    finally:
        os.close(marker)
    return True


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
