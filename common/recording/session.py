"""One recording from its start to its end: split into files by time and size, each complete in itself."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from common.clock import NS_PER_S
from common.errors import RecordingError
from common.recording.config import RecordConfig
from common.recording.folder import BYTES_PER_GB, file_name, prune
from common.recording.mcap_file import McapFile
from common.recording.reader import CLOCK_TABLE, EPOCH_KEY
from common.recording.records import MOST_TIME_NS
from common.recording.repair import repair
from common.recording.topics import Topic

FLUSH_NS = NS_PER_S
SECONDS_PER_MINUTE = 60
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


@dataclass(frozen=True, slots=True)
class RecordingPlan:
    """The place of a recording: its folder and cell, or one `file` of a given name, which is never split.

    `software` names who writes it.
    """

    folder: Path
    cell: str
    software: str
    config: RecordConfig
    file: Path | None = None


class RecordingSession:
    """Times come in by the host's monotonic clock; in the file they count from 1970, by the date of the beginning.

    It began at `began_ns`. `preamble` writes what every part has to contain. OSError of any call: nothing more can be
    written, `abandon` it.
    """

    def __init__(self, plan: RecordingPlan, began: datetime, now_ns: int, preamble: "Preamble") -> None:
        self._plan, self._began, self._preamble = plan, began, preamble
        self._epoch_ns = (began - EPOCH) // timedelta(microseconds=1) * 1000 - now_ns
        self.began_ns, self._finished_bytes = now_ns, 0
        self._part, self._begun_ns, self._flushed_ns = 0, now_ns, now_ns
        self._file = self._next_part(now_ns)

    @property
    def path(self) -> Path:
        """The file that grows."""
        return self._file.path

    @property
    def size_bytes(self) -> int:
        """The size of all its files, without what came since the last flush."""
        return self._finished_bytes + self._file.size

    def since_1970_ns(self, t_ns: int) -> int:
        """A time in the file; one that no reader takes, as an operator's sample may name, becomes the nearest."""
        return min(max(t_ns + self._epoch_ns, 0), MOST_TIME_NS - 1)

    def add(self, topic: Topic, data: bytes, t_ns: int, published_ns: int | None = None) -> None:
        """Keep a message of this time; `published_ns` is when it was sent, else the same."""
        published_ns = t_ns if published_ns is None else published_ns
        self._file.add(topic, data, self.since_1970_ns(t_ns), self.since_1970_ns(published_ns))

    def describe(self, name: str, table: dict[str, str]) -> None:
        """Keep a table of words; for the preamble."""
        self._file.describe(name, table)

    def attach(self, name: str, media_type: str, data: bytes, now_ns: int) -> None:
        """Keep a document; for the preamble."""
        self._file.attach(name, media_type, data, self.since_1970_ns(now_ns))

    def tend(self, now_ns: int) -> None:
        """Flush once a second; go on in a new file where it is time for one."""
        if now_ns - self._flushed_ns < FLUSH_NS:
            return
        self._flushed_ns = now_ns
        self._file.flush()
        config = self._plan.config
        if self._plan.file is not None:
            return
        prune(self._plan.folder, config.keep_gb, self._file.path)
        minutes = (now_ns - self._begun_ns) / NS_PER_S / SECONDS_PER_MINUTE
        is_full = self._file.size >= min(config.split_gb, config.keep_gb) * BYTES_PER_GB
        if minutes >= config.split_minutes or is_full:
            self._file.finish()
            self._finished_bytes += self._file.size
            self._file = self._next_part(now_ns)

    def end(self) -> None:
        """End in order."""
        self._file.finish()

    def abandon(self) -> None:
        """Nothing more can be written: make a whole file of what was."""
        self._file.close()
        repair(self._file.path)

    def _next_part(self, now_ns: int) -> McapFile:
        """The next file, with all that each one contains."""
        self._part += 1
        plan = self._plan
        path = plan.file or plan.folder / file_name(self._began, plan.cell, self._part)
        try:
            self._file = McapFile(path, plan.software)
        except FileExistsError as error:
            raise RecordingError(f"{path} exists already; give another name, or wait a second") from error
        self._begun_ns = self._flushed_ns = now_ns
        self._file.describe(CLOCK_TABLE, {EPOCH_KEY: str(self._epoch_ns), "part": str(self._part)})
        self._preamble(self, now_ns)
        return self._file


Preamble = Callable[[RecordingSession, int], None]
