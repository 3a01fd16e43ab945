"""The files of a site's memory in tmpfs: made under names that nobody can take beforehand, found by their owner."""

import fcntl
import os
import re
import secrets
import stat
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from common.atomic_file import OWNER_ONLY
from common.errors import ProcessError
from remote_site.link_config import RemoteLinksConfig

FOLDER = Path("/dev/shm")  # noqa: S108  # names are random, files are made exclusively, and their owner is checked
TOKEN_BYTES = 8
MEMORY, WAITING = "", ".waiting"
ROOT = 0
OPENING = os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW


def memory_place(cell: str, links: RemoteLinksConfig) -> Path:
    """Return where the site of this cell and these endpoints has its files: the folder, and how their names begin."""
    endpoints = f"{links.control} {links.router}".encode()
    return FOLDER / f"farhand-{cell}-{zlib.crc32(endpoints):08x}"


def make_file(place: Path, kind: str = MEMORY) -> tuple[Path, int]:
    """A new file, locked, and its handle; OSError where there can be none.

    Everybody may write to the folder, so that a name that could be guessed might be another user's already.
    """
    path = place.with_name(f"{place.name}-{secrets.token_hex(TOKEN_BYTES)}{kind}")
    handle = os.open(path, OPENING | os.O_CREAT | os.O_EXCL, OWNER_ONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)  # who looks whether it is held has it for a moment
    return path, handle


def own_files(place: Path, kind: str = MEMORY) -> dict[Path, int]:
    """The files of this user, for root those of all, with their owners; ProcessError where others may open its own."""
    user, found = os.geteuid(), dict[Path, int]()
    for path, facts in _files(place, kind):
        is_private = not facts.st_mode & 0o077
        if facts.st_uid == user and not is_private:
            raise ProcessError(f"{path} is not as a site makes it: others may open it; remove it")
        if user in (facts.st_uid, ROOT) and is_private:
            found[path] = facts.st_uid
    return found


def owners(place: Path) -> set[int]:
    """The numbers of all users who have a memory there."""
    return {facts.st_uid for _, facts in _files(place, MEMORY)}


def remove_left(place: Path, kind: str = MEMORY) -> None:
    """Remove what earlier runs left when they were killed: nobody holds it any more."""
    for path in own_files(place, kind):
        if not is_held(path):
            path.unlink(missing_ok=True)


def is_held(path: Path) -> bool:
    """Return whether a process has locked the file."""
    try:
        handle = os.open(path, OPENING)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(handle)
    return False


def _files(place: Path, kind: str) -> Iterator[tuple[Path, os.stat_result]]:
    named = re.compile(rf"{re.escape(place.name)}-[0-9a-f]{{{2 * TOKEN_BYTES}}}{re.escape(kind)}")
    names = os.listdir(place.parent) if place.parent.is_dir() else []
    for name in filter(named.fullmatch, names):
        with suppress(FileNotFoundError):  # removed meanwhile
            facts = os.lstat(place.with_name(name))
            if stat.S_ISREG(facts.st_mode):
                yield place.with_name(name), facts
