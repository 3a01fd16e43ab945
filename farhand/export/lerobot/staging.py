"""Staging of an export until it is complete: a folder beside the dataset, from which an interrupted one goes on."""

import fcntl
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import msgspec
import numpy as np

from common.atomic_file import write_atomically
from common.errors import ConfigError, ExportError, InterruptionError
from farhand.export.lerobot.statistics import Histogram
from farhand.export.videos.h264 import SUFFIX

LOCK, JOB, EPISODE, FRAMES = "lock", "job.json", "episode.json", "frames.parquet"


class ExportJob(msgspec.Struct, frozen=True):
    """The export's inputs and settings; another job does not go on with what this one has done."""

    sessions: tuple[str, ...]
    views: tuple[str, ...]
    fps: int
    task: str


class StagedEpisode(msgspec.Struct, frozen=True):
    """An episode that is encoded, and what the dataset says of it; `left_out` says why it is not in the dataset."""

    session: str
    begin_utc_ns: int
    number: int
    task: str
    success: bool | None
    note: str
    operator_clock_begin_ns: int = 0
    length: int = 0
    sampled: int = 0
    levels: dict[str, list[list[int]]] = {}
    left_out: str = ""

    def histogram(self, view: str) -> Histogram:
        """The levels (3, 256) of a view's sampled pictures."""
        return np.array(self.levels[view], np.int64)


class Staging:
    """The folder `OUT.part`, as a context manager that one export at a time holds.

    ConfigError if `out` exists or the folder has a person's own files, ExportError if another export is under way or
    has begun there.
    """

    def __init__(self, out: Path, job: ExportJob) -> None:
        self._out, self.folder, self._job = out, out.with_name(f"{out.name}.part"), job
        self._lock = -1

    def __enter__(self) -> Self:
        if self._out.exists() and (not self._out.is_dir() or any(self._out.iterdir())):
            raise ConfigError(f"--out {self._out} exists, and is never written over: give another, or remove it first")
        self.folder.mkdir(parents=True, exist_ok=True)
        self._refuse_others()
        self._lock = os.open(self.folder / LOCK, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            self._take()
        except ExportError:
            os.close(self._lock)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._lock)

    def begun(self, index: int) -> Path:
        """A folder for an episode that is to be encoded, empty whatever an interrupted export has left there."""
        folder = self._episode(index)
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def complete(self, index: int, episode: StagedEpisode) -> None:
        """The episode is encoded; its folder counts from now on."""
        write_atomically(self._episode(index) / EPISODE, msgspec.json.encode(episode))

    def staged(self, index: int) -> StagedEpisode | None:
        """The episode, if it is complete."""
        path = self._episode(index) / EPISODE
        return msgspec.json.decode(path.read_bytes(), type=StagedEpisode) if path.exists() else None

    def frames(self, index: int) -> Path:
        """Return where an episode's frames are."""
        return self._episode(index) / FRAMES

    def video(self, index: int, view: str) -> Path:
        """Return where an episode's pictures of a view are."""
        return self._episode(index) / f"{view}{SUFFIX}"

    def assembled(self) -> Path:
        """An empty folder for the dataset while it is put together."""
        folder = self.folder / "dataset"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        return folder

    @contextmanager
    def removed_by_failure(self) -> Iterator[None]:
        """Nothing is left behind by what fails for good; what only a person or the disk ended can go on."""
        try:
            yield
        except (InterruptionError, OSError):
            raise
        except Exception:  # whatever it was, it would fail again, and is raised
            shutil.rmtree(self.folder)
            raise

    def publish(self, assembled: Path) -> None:
        """Give the dataset its name, and remove what it was made from."""
        try:
            assembled.rename(self._out)
        except OSError as error:
            raise ExportError(
                f"--out {self._out} cannot be made: {error.strerror}; the same command tries again"
            ) from (error)
        shutil.rmtree(self.folder)

    def _episode(self, index: int) -> Path:
        return self.folder / f"{index:06d}"

    def _refuse_others(self) -> None:
        """ConfigError for a folder of a person's own, in which no export has begun."""
        names = {path.name for path in self.folder.iterdir()}
        if JOB not in names and (others := sorted(names - {LOCK, f"{JOB}.part"})):
            raise ConfigError(f"{self.folder} has {others[0]} in it, which no export made; give another --out")

    def _take(self) -> None:
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise ExportError(f"another export to {self._out} is under way; wait for it, or give another --out") from (
                error
            )
        path = self.folder / JOB
        if not path.exists():
            write_atomically(path, msgspec.json.encode(self._job))
            return
        if (kept := _job(path)) != self._job:
            changed = ", ".join(_changed(kept, self._job))
            cure = f"repeat that command to go on, give another --out, or remove {self.folder}"
            raise ExportError(f"{self.folder} is of an interrupted export with other {changed}: {cure}")


def _job(path: Path) -> ExportJob | None:
    try:
        return msgspec.json.decode(path.read_bytes(), type=ExportJob)
    except msgspec.DecodeError:
        return None


def _changed(kept: ExportJob | None, job: ExportJob) -> Sequence[str]:
    """The names of what differs."""
    if kept is None:
        return ["settings"]
    before: dict[str, Any] = msgspec.structs.asdict(kept)
    return [name for name, value in msgspec.structs.asdict(job).items() if before[name] != value]
