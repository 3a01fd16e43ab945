"""The memory in which the site leaves what a recorder of its host may take: a file of tmpfs, its owner's alone."""

import errno
import fcntl
import mmap
import os
from pathlib import Path
from typing import Self

from common.clock import NS_PER_S
from common.errors import ProcessError
from remote_site.recording.memory_files import (
    OPENING,
    ROOT,
    WAITING,
    is_held,
    make_file,
    own_files,
    owners,
    remove_left,
)
from remote_site.shared_ring import SharedRing

PAGE = mmap.PAGESIZE
MAGIC = b"farhand1"
BEAT_AT, TAKEN_AT = 64, 72
TICKS_BYTES = 16 << 20  # half a minute of control
PICTURES_BYTES = 64 << 20  # ten seconds of four cameras
REQUESTS_BYTES = STATUS_BYTES = 64 << 10
SIZES = TICKS_BYTES, PICTURES_BYTES, REQUESTS_BYTES, STATUS_BYTES
WHOLE = PAGE + sum(SIZES)
GONE_NS = 5 * NS_PER_S  # on a machine that does much else it may stand still for long, and the rings wait for it
AWAITED_NS = 25 * NS_PER_S  # from its start a site leaves its cycles for a recorder that waited: the ring holds more


class RecordingMemory:
    """Four rings: `ticks` is written by control, `pictures` by video, `requests` by control, `status` by the recorder.

    Without a recorder the memory costs nothing: room for the rings is taken when a recorder attaches, or waits already.
    It is taken whole, since a write for which there is no room left would kill control.
    """

    def __init__(self, path: Path, handle: int) -> None:
        self.path, self._handle = path, handle
        memory = memoryview(mmap.mmap(handle, WHOLE))
        self._magic = memory[: len(MAGIC)]
        self._beat, self._taken = memory[BEAT_AT:TAKEN_AT].cast("q"), memory[TAKEN_AT : TAKEN_AT + 8].cast("q")
        parts, at = [], PAGE
        for size in SIZES:
            parts.append(SharedRing(memory[at : at + size]))
            at += size
        self.ticks, self.pictures, self.requests, self.status = parts

    @classmethod
    def create(cls, place: Path, now_ns: int) -> Self:
        """New memory instead of what an earlier run left; ProcessError where it cannot be made.

        Create it before the fork: while the site or a process of it lives, the file is locked. A recorder that waits
        for this site counts as there from now on, however late it is scheduled.
        """
        awaited, folder = _is_awaited(place), place.parent
        try:
            path, handle = _new_file(place, WHOLE if awaited else PAGE)
        except OSError as error:
            cure = _free_room(folder, "site") if error.errno == errno.ENOSPC else f"see: ls -ld {folder}"
            raise ProcessError(f"nothing can be recorded in {folder}: {error.strerror}; {cure}") from error
        made = cls(path, handle)
        made._beat[0] = now_ns + AWAITED_NS - GONE_NS if awaited else now_ns - GONE_NS
        made._magic[:] = MAGIC
        return made

    @classmethod
    def attach(cls, place: Path) -> Self | None:
        """The memory of the site that runs, None while none does; files of other users are none of this site's.

        ProcessError where only another user has one, where root finds those of several, and where another process has
        attached to it.
        """
        user, live = os.geteuid(), {path: owner for path, owner in own_files(place).items() if is_held(path)}
        mine = [path for path, owner in live.items() if owner == user]
        others = set(live.values()) if user == ROOT else owners(place)
        in_doubt = len(others) > 1 if user == ROOT else others and user not in others
        if in_doubt and not mine:
            names = " and ".join(map(str, sorted(others)))
            raise ProcessError(f"{place}-* is of user {names}: run the recorder as the user of the remote site")
        return next((memory for path in mine or live if (memory := cls._attached(path)) is not None), None)

    @classmethod
    def _attached(cls, path: Path) -> Self | None:
        """The memory in this file, None while it is being made or once its site has ended."""
        try:
            handle = os.open(path, OPENING)
        except FileNotFoundError:
            return None
        if os.fstat(handle).st_size != WHOLE:
            os.close(handle)
            return None
        memory = cls(path, handle)
        if memory._magic != MAGIC or memory.is_left():
            memory.close()
            return None
        memory._claim()
        memory._take_room()
        return memory

    def _claim(self) -> None:
        """Be the one recorder: of two, both would write the status."""
        try:
            fcntl.lockf(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB, 1)  # of this process, beside the site's flock
        except BlockingIOError as error:
            self.close()
            raise ProcessError(f"another recorder is at {self.path}; end it first") from error

    def _take_room(self) -> None:
        """Have a page for every byte, before control and video see a recorder."""
        try:
            os.posix_fallocate(self._handle, 0, WHOLE)
        except OSError as error:
            self.close()
            raise ProcessError(
                f"nothing can be recorded: {error.strerror}; {_free_room(self.path.parent, 'recorder')}"
            ) from error

    def is_left(self) -> bool:
        """Return whether no process of the site lives any more, or another run has its place; for the recorder."""
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno not in (errno.EWOULDBLOCK, errno.EACCES):
                raise
            return not self._is_named()
        fcntl.flock(self._handle, fcntl.LOCK_UN)  # the mapping would hold it on, and look like a site
        return True

    def take_over(self) -> bool:
        """Take over this site's rings; return whether nobody has read them: then they are read from the beginning."""
        is_first, self._taken[0] = self._taken[0] == 0, 1
        return is_first

    def beat(self, now_ns: int) -> None:
        """A recorder is there; it beats several times a second."""
        self._beat[0] = now_ns

    def has_recorder(self, now_ns: int) -> bool:
        """Return whether a recorder has beaten within the last seconds."""
        return now_ns - self._beat[0] < GONE_NS

    def close(self) -> None:
        """Let go of the file; the mapping, and with it the lock, ends with its last user."""
        os.close(self._handle)

    def remove(self) -> None:
        """Remove the file: the site ends in order."""
        if self._is_named():
            self.path.unlink(missing_ok=True)

    def _is_named(self) -> bool:
        try:
            return os.stat(self.path).st_ino == os.fstat(self._handle).st_ino
        except FileNotFoundError:
            return False


def wait_for_site(place: Path) -> tuple[Path, int] | None:
    """Show a site that is still to start that a recorder waits; the handle keeps it so, None where another waits."""
    if _is_awaited(place):
        return None
    remove_left(place, WAITING)
    try:
        return make_file(place, WAITING)
    except OSError as error:
        raise ProcessError(
            f"no recorder can wait in {place.parent}: {error.strerror}; see: ls -ld {place.parent}"
        ) from error


def stop_waiting(waits: tuple[Path, int]) -> None:
    """Take back what `wait_for_site` has shown."""
    path, handle = waits
    path.unlink(missing_ok=True)
    os.close(handle)


def _new_file(place: Path, room_bytes: int) -> tuple[Path, int]:
    """A file of the whole size, with room for its first bytes; what an earlier run left goes."""
    remove_left(place)
    path, handle = make_file(place)
    try:
        os.ftruncate(handle, WHOLE)
        os.posix_fallocate(handle, 0, room_bytes)
    except OSError:
        os.close(handle)
        path.unlink(missing_ok=True)
        raise
    return path, handle


def _free_room(folder: Path, who: str) -> str:
    return f"free {WHOLE >> 20} MB in {folder}, and start the {who} again"


def _is_awaited(place: Path) -> bool:
    """Return whether a recorder of this user waits: no other may read what this user leaves."""
    return any(is_held(path) for path in own_files(place, WAITING))
