"""Reads an MCAP file record by record up to where it is whole, and notes what its index needs."""

import struct
import zlib
from array import array
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from io import BytesIO
from typing import IO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Metadata,
    MetadataIndex,
    Schema,
)

from common.recording.chunks import CHUNK_HEAD, COMPRESSION, CONTENT_LENGTH, MESSAGE_HEAD, decompressed, records_in
from common.recording.records import (
    BROKEN,
    MAGIC,
    MOST_TABLE_BYTES,
    MOST_TIME_NS,
    RECORD_HEADER,
    RecordHead,
    check_described,
    content_of,
    next_head,
)

MESSAGE_INDEX_HEAD = struct.Struct("<HI")  # its channel, and the length of the rows that follow
INDEX_ROW_BYTES = 16  # when a message is, and where


@dataclass
class FileIndex:
    """The contents of a file's data section, as the summary at its end lists them.

    `described_bytes` are those of schemas, channels and names; `end` is where its last whole record ends; `unindexed`
    are the indexes that the last chunk lacks there: by channel, time and place of each message in turn.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)
    attachments: list[AttachmentIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    messages: Counter[int] = field(default_factory=Counter)
    unindexed: dict[int, "array[int]"] = field(default_factory=dict)
    described_bytes: int = 0
    end: int = 0

    @property
    def span_ns(self) -> tuple[int, int]:
        """The times of the first message and the last."""
        first = min((chunk.message_start_time for chunk in self.chunks), default=0)
        return first, max((chunk.message_end_time for chunk in self.chunks), default=0)


ShowBytes = Callable[[int, int], None]  # how many bytes are read, of how many


def scan(file: IO[bytes], show: ShowBytes = lambda _done, _size: None) -> FileIndex:
    """Everything up to the first record that is cut or broken; ValueError for another kind of file."""
    size = file.seek(0, 2)
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        raise ValueError("it does not begin as an MCAP file")
    index = FileIndex(end=len(MAGIC))
    while (head := next_head(file, index.end, size)) is not None:
        if head.opcode in (Opcode.DATA_END, Opcode.FOOTER):
            break
        try:
            _take(index, head, content_of(file, head))
        except BROKEN:
            break
        index.end = head.end
        show(head.end, size)
    return index


def _take(index: FileIndex, head: RecordHead, content: bytes) -> None:
    stream, whole = ReadDataStream(BytesIO(content)), RECORD_HEADER.size + head.length
    match head.opcode:
        case Opcode.CHUNK:
            _take_chunk(index, head, content)
        case Opcode.MESSAGE_INDEX:
            channel, length = MESSAGE_INDEX_HEAD.unpack_from(content)
            if length != len(content) - MESSAGE_INDEX_HEAD.size or length % INDEX_ROW_BYTES:
                raise ValueError("a message index that is not as long as it says")
            last = index.chunks[-1]
            index.unindexed.pop(channel, None)
            last.message_index_offsets[channel] = head.start
            last.message_index_length += whole
        case Opcode.ATTACHMENT:
            a = Attachment.read(stream)
            row = AttachmentIndex(head.start, whole, a.log_time, a.create_time, len(a.data), a.name, a.media_type)
            if int.from_bytes(content[-4:], "little") == zlib.crc32(content[:-4]):  # else it stays, and nobody finds it
                _describe(index, len(content) - len(a.data))
                index.attachments.append(row)
        case Opcode.METADATA if head.length <= MOST_TABLE_BYTES:
            index.metadata.append(MetadataIndex(head.start, whole, Metadata.read(stream).name))
            _describe(index, whole)


def _describe(index: FileIndex, size: int) -> None:
    """Count so many more bytes of schemas, channels or names; ValueError beyond those of a recorder's file."""
    index.described_bytes += size
    check_described(index.described_bytes)


def _take_chunk(index: FileIndex, head: RecordHead, content: bytes) -> None:
    """Read a chunk to its end before anything of it counts; ValueError for one that a reader would refuse."""
    data = decompressed(content)
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    indexes: dict[int, array[int]] = {}
    for opcode, begin, end in records_in(data):
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            check_described(end - begin)
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(ReadDataStream(BytesIO(data[begin:end])))
            schemas[schema.id] = schema
            _describe(index, end - begin if schema != index.schemas.get(schema.id) else 0)
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(ReadDataStream(BytesIO(data[begin:end])))
            channels[channel.id] = channel
            _describe(index, end - begin if channel != index.channels.get(channel.id) else 0)
        elif opcode == Opcode.MESSAGE:
            number, _, log_ns, published_ns = MESSAGE_HEAD.unpack(data[begin:end][: MESSAGE_HEAD.size])
            if max(log_ns, published_ns) >= MOST_TIME_NS or not (number in channels or number in index.channels):
                raise ValueError("a message that no recorder wrote")
            if number not in indexes:
                indexes[number] = array("Q")
            indexes[number].extend((log_ns, begin - RECORD_HEADER.size))
    index.schemas |= schemas
    index.channels |= channels
    index.unindexed = indexes
    index.messages.update({channel: len(places) // 2 for channel, places in indexes.items()})
    index.chunks.append(
        ChunkIndex(
            chunk_length=RECORD_HEADER.size + head.length,
            chunk_start_offset=head.start,
            compression=COMPRESSION.decode(),
            compressed_size=head.length - CHUNK_HEAD.size - len(COMPRESSION) - CONTENT_LENGTH.size,
            message_end_time=max((max(places[::2]) for places in indexes.values()), default=0),
            message_index_length=0,
            message_index_offsets={},
            message_start_time=min((min(places[::2]) for places in indexes.values()), default=0),
            uncompressed_size=len(data),
        )
    )
