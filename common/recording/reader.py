"""Reads a recording: its descriptions, documents and messages, in the order of their times; in bounded memory."""

import heapq
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import IO, NamedTuple, Self
from xml.etree import ElementTree

from google.protobuf.message import DecodeError

from common.clock import NS_PER_S
from common.errors import MessageError, RecordingError
from common.recording.chunks import ChunkMessage
from common.recording.mcap_file import is_being_written
from common.recording.records import BROKEN, MAGIC, MOST_TIME_NS
from common.recording.summary import FileSummary, channels_of, read_summary

CLOCK_TABLE = "farhand.clock"
EPOCH_KEY = "epoch_minus_clock_ns"
UNREADABLE = (
    MessageError,
    DecodeError,
    ElementTree.ParseError,
    LookupError,
    ValueError,
    OverflowError,
    RecursionError,  # of JSON within JSON within JSON
)


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
            self._summary = self._read_summary()
            self._epoch_ns = self._read_epoch()
        except RecordingError:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    @property
    def topics(self) -> dict[str, int]:
        """Every topic, and how many messages it has."""
        return {topic: self._summary.counts.get(number, 0) for number, topic in self._summary.topics.items()}

    @property
    def seconds(self) -> float:
        """From the first message to the last."""
        begin_ns, end_ns = self.span_ns
        return (end_ns - begin_ns) / NS_PER_S

    def table(self, name: str) -> dict[str, str]:
        """A table of words about the recording; KeyError without it, RecordingError where it is damaged."""
        if name not in self._summary.tables:
            raise KeyError(name)
        with self._whole():
            return self._summary.table(self._file, name)

    def document(self, name: str) -> bytes:
        """An attached document; KeyError without it, RecordingError where it is damaged."""
        if name not in self._summary.documents:
            raise KeyError(name)
        with self._whole():
            return self._summary.document(self._file, name)

    @property
    def span_ns(self) -> tuple[int, int]:
        """The times of the first message and the last, by the monotonic clock of the host that recorded it."""
        if not self._summary.chunks:
            return 0, 0
        begin_ns, end_ns = self._summary.span_ns
        return begin_ns - self._epoch_ns, end_ns - self._epoch_ns

    @property
    def epoch_minus_clock_ns(self) -> int:
        """The offset that turns its times into ns since 1970, UTC."""
        return self._epoch_ns

    def messages(
        self, topics: Sequence[str] | None = None, begin_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[KeptMessage]:
        """The messages of these topics (all by default) from `begin_ns` on and before `end_ns`, by their times.

        RecordingError where the file is damaged.
        """
        wanted = {number: name for number, name in self._summary.topics.items() if topics is None or name in topics}
        begin = 0 if begin_ns is None else begin_ns + self._epoch_ns
        end = MOST_TIME_NS if end_ns is None else end_ns + self._epoch_ns
        with self._whole():
            for message in self._merged(wanted.keys(), begin, end):
                times = message.log_ns - self._epoch_ns, message.published_ns - self._epoch_ns
                yield KeptMessage(wanted[message.channel], *times, message.data)

    def _merged(self, channels: Set[int], begin: int, end: int) -> Iterator[ChunkMessage]:
        """The messages of these channels, by their times; a chunk is open from its first message to its last."""
        wanted = (place for place in self._summary.chunks if place.begin_ns < end and place.end_ns >= begin)
        waiting = [place for place in wanted if not place.channels or not channels.isdisjoint(channels_of(place))]
        waiting.sort(key=lambda place: (place.begin_ns, place.start), reverse=True)
        ahead: list[tuple[int, int, ChunkMessage, Iterator[ChunkMessage]]] = []  # of each open chunk
        while waiting or ahead:
            while waiting and (not ahead or waiting[-1].begin_ns <= ahead[0][0]):
                place = waiting.pop()
                messages = self._summary.messages_of(self._file, place, channels, begin, end)
                if (first := next(messages, None)) is not None:
                    heapq.heappush(ahead, (first.log_ns, place.start, first, messages))
            if not ahead:
                continue
            _, start, message, messages = ahead[0]
            if (after := next(messages, None)) is None:
                heapq.heappop(ahead)
            else:
                heapq.heapreplace(ahead, (after.log_ns, start, after, messages))
            yield message

    def _read_summary(self) -> FileSummary:
        try:
            return read_summary(self._file)
        except (*BROKEN, OSError) as error:
            raise RecordingError(f"{self.path} {_what_is_wrong(self._file, error)}") from error

    def _read_epoch(self) -> int:
        try:
            return epoch_in(self.table(CLOCK_TABLE))
        except (KeyError, ValueError) as error:
            raise RecordingError(f"{self.path} is no recording of Farhand, or nothing was recorded in it") from error

    @contextmanager
    def _whole(self) -> Iterator[None]:
        """RecordingError, with the cure, for what damage makes of a reader."""
        try:
            yield
        except (*BROKEN, OSError) as error:
            cure = f"get it again from where it was recorded, or keep what is whole: {_repair(self.path)}"
            raise RecordingError(f"{self.path} is damaged ({_words(error)}): {cure}") from error


@contextmanager
def as_recorded(path: Path) -> Iterator[None]:
    """RecordingError for what a recorder wrote into a file and this release cannot decode."""
    try:
        yield
    except UNREADABLE as error:
        cure = "use the release that recorded it, or get it again from there"
        raise RecordingError(f"{path}: what is in it cannot be read ({_words(error)}); {cure}") from error


def epoch_in(table: Mapping[str, str]) -> int:
    """Read what turns a recording's times into ns since 1970 from its table of the clock; ValueError if damaged."""
    words = table.get(EPOCH_KEY, "")
    if not words.removeprefix("-").isdecimal() or len(words) > 20 or abs(int(words)) >= MOST_TIME_NS:
        raise ValueError("its table of the clock is damaged, so that no message of it has a time")
    return int(words)


def _check_begins(path: Path, file: IO[bytes]) -> None:
    try:
        begin = file.read(len(MAGIC))
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror}") from error
    if begin != MAGIC:
        raise RecordingError(f"{path} is no recording: it does not begin as an MCAP file")
    file.seek(0)


def _what_is_wrong(file: IO[bytes], error: Exception) -> str:
    """Why a file has no index that can be read, with the cure."""
    if is_being_written(file):
        return "is being recorded: end the recording first"
    cure = f"if its recorder was killed, or a copy was cut: {_repair(Path(file.name))}"
    return f"is no whole recording, its end is missing or damaged ({_words(error)}); {cure}"


def _repair(path: Path) -> str:
    return f"farhand record repair {path}"


def _words(error: Exception) -> str:
    return str(error) or type(error).__name__
