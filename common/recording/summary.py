"""Summary at the end of a recording: its topics, its chunks, where its tables and documents are; checked."""

import struct
import zlib
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, field
from io import BytesIO
from typing import IO, NamedTuple

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, AttachmentIndex, Channel, Metadata, MetadataIndex, Statistics

from common.clock import NS_PER_S
from common.recording.chunks import ChunkMessage, decompressed, messages_in
from common.recording.records import (
    MAGIC,
    MOST_CHUNK_BYTES,
    MOST_TABLE_BYTES,
    MOST_TIME_NS,
    RECORD_HEADER,
    check_described,
    content_of,
    next_head,
    record_at,
)

FOOTER = struct.Struct("<QQI")  # where the summary begins, where its offsets begin, its CRC
FOOTER_BYTES = RECORD_HEADER.size + FOOTER.size
CHUNK_ROW = struct.Struct("<QQQQI")  # first and last time, where and how long it is, the length of its channels' rows
CHANNEL_ROW = np.dtype([("channel", "<u2"), ("at", "<u8")])
CHUNK_ROW_END = struct.Struct("<QI")  # the length of its message indexes, that of the compression's name
SIZES = struct.Struct("<QQ")
MOST_AT_ONCE_BYTES = 2 * MOST_CHUNK_BYTES  # of chunks of one time, which are open together
LONGEST_NS = 31 * 24 * 3600 * NS_PER_S


class ChunkPlace(NamedTuple):
    """A chunk: times of its first and last message, where it begins, its size decompressed, and its channels."""

    begin_ns: int
    end_ns: int
    start: int
    size: int
    channels: bytes  # their numbers, two bytes each: equal ones are one object


@dataclass
class FileSummary:
    """The contents of a file whose length is `size`; times in ns since the epoch of the file."""

    size: int
    topics: dict[int, str] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    span_ns: tuple[int, int] = (0, 0)
    chunks: list[ChunkPlace] = field(default_factory=list)
    tables: dict[str, int] = field(default_factory=dict)  # by name, where the record begins
    documents: dict[str, int] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """The number of messages."""
        return sum(self.counts.values())

    def table(self, file: IO[bytes], name: str) -> dict[str, str]:
        """A table of words; KeyError without it, ValueError where it is damaged."""
        content = record_at(file, Opcode.METADATA, self.tables[name], self.size)
        if len(content) > MOST_TABLE_BYTES:
            raise ValueError(f"a table of {len(content) >> 10} kB; recorders write at most {MOST_TABLE_BYTES >> 10}")
        read = Metadata.read(_stream(content))
        if read.name != name:
            raise ValueError(f"the table {name!r} has another name")
        return dict(read.metadata)

    def document(self, file: IO[bytes], name: str) -> bytes:
        """An attached document; KeyError without it, ValueError where it is damaged."""
        content = record_at(file, Opcode.ATTACHMENT, self.documents[name], self.size)
        read = Attachment.read(_stream(content))
        if read.name != name or zlib.crc32(content[:-4]) != int.from_bytes(content[-4:], "little"):
            raise ValueError(f"the document {name!r} is damaged")
        return bytes(read.data)

    def messages_of(
        self, file: IO[bytes], place: ChunkPlace, channels: Set[int], begin_ns: int = 0, end_ns: int = MOST_TIME_NS
    ) -> Iterator[ChunkMessage]:
        """As `messages_in` of this chunk; ValueError where it is damaged, or another than the summary says."""
        data = decompressed(record_at(file, Opcode.CHUNK, place.start, self.size))
        if len(data) != place.size:
            raise ValueError("a chunk of another size than its index says")
        for message in messages_in(data, channels, begin_ns, end_ns):
            if not place.begin_ns <= message.log_ns <= place.end_ns:
                raise ValueError("a message of another time than its index says")
            yield message


def read_summary(file: IO[bytes]) -> FileSummary:
    """The summary at a file's end; one of the BROKEN errors where there is none that is whole and a recorder's."""
    size = file.seek(0, 2)
    begin = _summary_begin(file, size)
    summary, seen = FileSummary(size), dict[bytes, bytes]()
    end, described = size - len(MAGIC) - FOOTER_BYTES, 0
    while begin < end:
        head = next_head(file, begin, end)
        if head is None:
            raise ValueError("its index is cut")
        described += head.length if head.opcode != Opcode.CHUNK_INDEX else 0
        check_described(max(described, head.length) // 2)  # its rows, of what is described, take as much at most
        _take(summary, head.opcode, content_of(file, head), seen)
        begin = head.end
    if summary.chunks and not summary.counts:
        raise ValueError("its index counts no messages")
    check_chunks(summary.chunks, size)
    return summary


def _summary_begin(file: IO[bytes], size: int) -> int:
    """Find where the summary begins, by the footer; ValueError where the end of the file is damaged."""
    at = size - len(MAGIC) - FOOTER_BYTES
    if at < len(MAGIC):
        raise ValueError("it is too short")
    begin: int
    begin, _, crc = FOOTER.unpack(record_at(file, Opcode.FOOTER, at, size))
    if file.read(len(MAGIC)) != MAGIC or not len(MAGIC) <= begin < at:
        raise ValueError("its end is missing")
    if crc != _check_sum(file, begin, at + FOOTER_BYTES - 4):
        raise ValueError("the check sum of its index is wrong")
    return begin


def _check_sum(file: IO[bytes], begin: int, end: int) -> int:
    crc, left = 0, end - begin
    file.seek(begin)
    while left and (part := file.read(min(left, 1 << 20))):
        crc, left = zlib.crc32(part, crc), left - len(part)
    return crc


def _take(summary: FileSummary, opcode: int, content: bytes, seen: dict[bytes, bytes]) -> None:
    match opcode:
        case Opcode.CHANNEL:
            channel = Channel.read(_stream(content))
            summary.topics[channel.id] = channel.topic
        case Opcode.STATISTICS:
            statistics = Statistics.read(_stream(content))
            summary.counts = dict(statistics.channel_message_counts)
            summary.span_ns = statistics.message_start_time, statistics.message_end_time
            check_span(*summary.span_ns)
        case Opcode.CHUNK_INDEX:
            summary.chunks.append(_chunk_place(content, seen))
        case Opcode.ATTACHMENT_INDEX:
            attachment = AttachmentIndex.read(_stream(content))
            summary.documents.setdefault(attachment.name, attachment.offset)
        case Opcode.METADATA_INDEX:
            metadata = MetadataIndex.read(_stream(content))
            summary.tables.setdefault(metadata.name, metadata.offset)


def _chunk_place(content: bytes, seen: dict[bytes, bytes]) -> ChunkPlace:
    begin_ns, end_ns, start, _, length = CHUNK_ROW.unpack_from(content)
    rows = np.frombuffer(content, CHANNEL_ROW, length // CHANNEL_ROW.itemsize, CHUNK_ROW.size)
    at = CHUNK_ROW.size + length
    _, name_length = CHUNK_ROW_END.unpack_from(content, at)
    _, size = SIZES.unpack_from(content, at + CHUNK_ROW_END.size + name_length)
    channels = rows["channel"].tobytes()
    return ChunkPlace(begin_ns, end_ns, start, size, seen.setdefault(channels, channels))


def check_chunks(chunks: Sequence[ChunkPlace], size: int) -> None:
    """ValueError for chunks that lie beyond a file of this size, or take more memory at a time than recorders' do."""
    for chunk in chunks:
        check_span(chunk.begin_ns, chunk.end_ns)
        if chunk.start >= size or chunk.size > MOST_CHUNK_BYTES:
            raise ValueError(f"a chunk of {chunk.size >> 20} MB at byte {chunk.start}, of {size} bytes")
    if len({chunk.start for chunk in chunks}) < len(chunks):
        raise ValueError("an index that names a chunk twice")
    begins = np.array([chunk.begin_ns for chunk in chunks], np.int64)
    ends = np.array([chunk.end_ns for chunk in chunks], np.int64)
    sizes = np.array([chunk.size for chunk in chunks], np.int64)
    times = np.concatenate((begins, ends))
    order = np.lexsort((np.repeat([0, 1], len(chunks)), times))  # where one ends as another begins, both are open
    open_bytes = np.cumsum(np.concatenate((sizes, -sizes))[order])
    if len(chunks) and open_bytes.max() > MOST_AT_ONCE_BYTES:
        most = int(open_bytes.max()) >> 20
        raise ValueError(f"{most} MB of it are of one time; at most {MOST_AT_ONCE_BYTES >> 20} are read")


def check_span(begin_ns: int, end_ns: int) -> None:
    """ValueError for times of a first message and a last that no recording has."""
    if not begin_ns <= end_ns < MOST_TIME_NS or end_ns - begin_ns > LONGEST_NS:
        raise ValueError("times that are no recording's: a month is the longest")


def _stream(content: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(content))


def channels_of(place: ChunkPlace) -> Iterator[int]:
    """The numbers of a chunk's channels."""
    return iter(np.frombuffer(place.channels, "<u2").tolist())
