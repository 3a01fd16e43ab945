"""The folder of recordings: their names, by date, and which of the oldest have to go; its owner's alone."""

import os
import re
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

import structlog

from common.errors import ConfigError

FOLDER_MODE = 0o700
STATE_HOME = "~/.local/state"  # where XDG_STATE_HOME is not set
BYTES_PER_GB = 10**9
NAME = re.compile(r"\d{8}T\d{6}Z_[a-z0-9_-]+_\d{3}\.mcap")


class FoundFile(NamedTuple):
    """A file of a recording, and its size in bytes."""

    path: Path
    size: int


def recordings_folder(configured: str, name: str) -> Path:
    """The configured folder, else the one of this name in the service's state folder, or the user's."""
    if configured:
        return Path(configured)
    service = os.environ.get("STATE_DIRECTORY")
    state = Path(service) if service else Path(os.environ.get("XDG_STATE_HOME") or STATE_HOME).expanduser() / "farhand"
    return state / name


def make_private(folder: Path) -> None:
    """Make the folder, its owner's alone; ConfigError where that is not possible, or others may look into it."""
    try:
        folder.mkdir(mode=FOLDER_MODE, parents=True, exist_ok=True)
        facts = folder.stat()
    except OSError as error:
        raise ConfigError(f"no recording can be kept in {folder}: {error.strerror}; give another --out") from error
    if facts.st_mode & 0o077:
        raise ConfigError(f"others may look into {folder}: chmod 700 {folder}, or give another --out")


def file_name(began: datetime, cell: str, part: int) -> str:
    """The name of a recording's part, from 1; names sort by time."""
    return f"{began:%Y%m%dT%H%M%SZ}_{cell}_{part:03d}.mcap"


def found(folder: Path) -> list[FoundFile]:
    """The recordings in a folder, the oldest first; other files are none."""
    files = sorted(path for path in folder.iterdir() if NAME.fullmatch(path.name) and path.is_file())
    return [FoundFile(path, path.stat().st_size) for path in files]


def too_old(files: Sequence[FoundFile], keep_bytes: float, growing: Path | None) -> list[Path]:
    """The oldest files, until the rest fits into `keep_bytes`; never the one that grows."""
    left, gone = sum(file.size for file in files), []
    for file in files:
        if left <= keep_bytes:
            break
        if file.path != growing:
            gone.append(file.path)
            left -= file.size
    return gone


def prune(folder: Path, keep_gb: float, growing: Path | None) -> None:
    """Remove the oldest recordings beyond `keep_gb`, each with a line in the log."""
    for path in too_old(found(folder), keep_gb * BYTES_PER_GB, growing):
        path.unlink(missing_ok=True)
        structlog.get_logger().info("an old recording is removed", file=str(path), keep_gb=keep_gb)


def parts_from(path: Path) -> list[Path]:
    """A file and the parts of the same recording that follow it, in order; a file of another name stands alone."""
    if not NAME.fullmatch(path.name):
        return [path]
    recording = path.name.rpartition("_")[0]
    parts = sorted(path.parent.glob(f"{recording}_[0-9][0-9][0-9].mcap"))
    return [part for part in parts if part.name >= path.name] or [path]
