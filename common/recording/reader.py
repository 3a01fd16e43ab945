"""Reads a recording: its descriptions, documents and messages, in the order of their times."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, NamedTuple, Self

from mcap.reader import make_reader

from common.clock import NS_PER_S
from common.errors import RecordingError
from common.recording.mcap_file import is_being_written
from common.recording.scan import BROKEN, MAGIC

CLOCK_TABLE = "farhand.clock"
EPOCH_KEY = "epoch_minus_clock_ns"


class KeptMessage(NamedTuple):
    """A message of a recording, `t_ns` and `published_ns` by the monotonic clock of the host that recorded it."""

    topic: str
    t_ns: int
    published_ns: int
    data: bytes


class RecordingReader:
    """One file of a recording, as a context manager; RecordingError for what is no whole recording."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = path.open("rb")
        except OSError as error:
            raise RecordingError(f"{path} cannot be read: {error.strerror}") from error
        try:
            _check_begins(path, self._file)
            self._reader = make_reader(self._file, validate_crcs=True)
            self._summary = self._reader.get_summary()
            self._epoch_ns = int(self.table(CLOCK_TABLE)[EPOCH_KEY])
        except KeyError as error:
            self._file.close()
            raise RecordingError(f"{path} is no recording of Farhand, or nothing was recorded in it") from error
        except RecordingError:
            self._file.close()
            raise
        except (*BROKEN, OSError) as error:
            with self._file:
                raise RecordingError(f"{path} {_what_is_wrong(self._file)}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    @property
    def topics(self) -> dict[str, int]:
        """Every topic, and how many messages it has."""
        summary = self._summary
        if summary is None or summary.statistics is None:
            return {}
        counts = summary.statistics.channel_message_counts
        return {channel.topic: counts.get(channel.id, 0) for channel in summary.channels.values()}

    @property
    def seconds(self) -> float:
        """From the first message to the last."""
        begin_ns, end_ns = self.span_ns
        return (end_ns - begin_ns) / NS_PER_S

    def table(self, name: str) -> dict[str, str]:
        """A table of words about the recording; KeyError without it."""
        for table in self._reader.iter_metadata():
            if table.name == name:
                return table.metadata
        raise KeyError(name)

    def document(self, name: str) -> bytes:
        """An attached document; KeyError without it."""
        for attachment in self._reader.iter_attachments():
            if attachment.name == name:
                return bytes(attachment.data)
        raise KeyError(name)

    @property
    def span_ns(self) -> tuple[int, int]:
        """The times of the first message and the last, by the monotonic clock of the host that recorded it."""
        statistics = self._summary.statistics if self._summary is not None else None
        if statistics is None:
            return 0, 0
        return statistics.message_start_time - self._epoch_ns, statistics.message_end_time - self._epoch_ns

    @property
    def epoch_minus_clock_ns(self) -> int:
        """What turns its times into ns since 1970, UTC."""
        return self._epoch_ns

    def messages(
        self, topics: Sequence[str] | None = None, begin_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[KeptMessage]:
        """The messages of these topics (all by default) from `begin_ns` on and before `end_ns`, by their times.

        RecordingError where the file is damaged.
        """
        begin, end = (None if t_ns is None else max(t_ns + self._epoch_ns, 0) for t_ns in (begin_ns, end_ns))
        try:
            for _, channel, message in self._reader.iter_messages(topics, starting_at=begin, ending_before=end):
                times = message.log_time - self._epoch_ns, message.publish_time - self._epoch_ns
                yield KeptMessage(channel.topic, *times, message.data)
        except BROKEN as error:
            raise RecordingError(
                f"{self.path} is damaged ({error}): get it again from where it was recorded"
            ) from error


def _check_begins(path: Path, file: IO[bytes]) -> None:
    try:
        begin = file.read(len(MAGIC))
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror}") from error
    if begin != MAGIC:
        raise RecordingError(f"{path} is no recording: it does not begin as an MCAP file")
    file.seek(0)


def _what_is_wrong(file: IO[bytes]) -> str:
    """Why a file has no index that can be read, with the cure."""
    if is_being_written(file):
        return "is being recorded: end the recording first"
    cure = f"if its recorder was killed, or a copy was cut: farhand record repair {file.name}"
    return f"is no whole recording, its end is missing; {cure}"
