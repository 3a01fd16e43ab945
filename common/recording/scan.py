"""Reads an MCAP file record by record up to where it is whole, and notes what its index needs."""

import struct
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from io import BytesIO
from typing import IO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
)
from mcap.stream_reader import get_chunk_data_stream

MAGIC = b"\x89MCAP0\r\n"
RECORD_HEADER = struct.Struct("<BQ")
BROKEN = (McapError, ValueError, RuntimeError, struct.error, EOFError)  # lz4 raises RuntimeError


class RecordHead(NamedTuple):
    """A record's kind, where it begins, and the length of its content."""

    opcode: int
    start: int
    length: int

    @property
    def end(self) -> int:
        return self.start + RECORD_HEADER.size + self.length


@dataclass
class FileIndex:
    """What is in the data section of a file, as the summary at its end lists it.

    `end` is where the last whole record ends; `unindexed` are the message indexes that the last chunk lacks there.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)
    attachments: list[AttachmentIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    messages: Counter[int] = field(default_factory=Counter)
    unindexed: dict[int, MessageIndex] = field(default_factory=dict)
    end: int = 0
    is_finished: bool = False


class NotMcapError(ValueError):
    """The file does not begin as an MCAP file."""


ShowBytes = Callable[[int, int], None]  # how many bytes are read, of how many


def scan(file: IO[bytes], show: ShowBytes = lambda _done, _size: None) -> FileIndex:
    """Everything up to the first record that is cut or broken; NotMcapError for another kind of file."""
    size = file.seek(0, 2)
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        raise NotMcapError("it does not begin as an MCAP file")
    index = FileIndex(end=len(MAGIC))
    while (head := _next_head(file, index.end, size)) is not None:
        if head.opcode in (Opcode.DATA_END, Opcode.FOOTER):
            file.seek(size - len(MAGIC))
            index.is_finished = file.read() == MAGIC and _footer_is_there(file, size)
            break
        try:
            _take(index, head, file.read(head.length))
        except BROKEN:
            break
        index.end = head.end
        show(head.end, size)
    return index


def _next_head(file: IO[bytes], start: int, size: int) -> RecordHead | None:
    """The record that begins there, None where it is cut."""
    file.seek(start)
    read = file.read(RECORD_HEADER.size)
    if len(read) < RECORD_HEADER.size:
        return None
    opcode, length = RECORD_HEADER.unpack(read)
    head = RecordHead(opcode, start, length)
    return head if head.end <= size else None


def _footer_is_there(file: IO[bytes], size: int) -> bool:
    """Whether the summary's end is that of a whole file."""
    footer = RECORD_HEADER.size + 20
    file.seek(max(size - len(MAGIC) - footer, 0))
    opcode, length = RECORD_HEADER.unpack(file.read(RECORD_HEADER.size))
    return bool(opcode == Opcode.FOOTER and length == 20)


def _take(index: FileIndex, head: RecordHead, content: bytes) -> None:
    stream, whole = ReadDataStream(BytesIO(content)), RECORD_HEADER.size + head.length
    match head.opcode:
        case Opcode.CHUNK:
            _take_chunk(index, head, Chunk.read(stream))
        case Opcode.MESSAGE_INDEX:
            channel = MessageIndex.read(stream).channel_id
            last = index.chunks[-1]
            index.unindexed.pop(channel, None)
            last.message_index_offsets[channel] = head.start
            last.message_index_length += whole
        case Opcode.ATTACHMENT:
            a = Attachment.read(stream)
            row = AttachmentIndex(head.start, whole, a.log_time, a.create_time, len(a.data), a.name, a.media_type)
            index.attachments.append(row)
        case Opcode.METADATA:
            index.metadata.append(MetadataIndex(head.start, whole, Metadata.read(stream).name))


def _take_chunk(index: FileIndex, head: RecordHead, chunk: Chunk) -> None:
    """Read a chunk to its end before anything of it counts."""
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    indexes: dict[int, MessageIndex] = {}
    while stream.count < length:
        at, opcode, size = stream.count, stream.read1(), stream.read8()
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(stream)
            channels[channel.id] = channel
        elif opcode == Opcode.MESSAGE:
            message = Message.read(stream, size)
            indexes.setdefault(message.channel_id, MessageIndex(message.channel_id, []))
            indexes[message.channel_id].records.append((message.log_time, at))
    index.schemas |= schemas
    index.channels |= channels
    index.unindexed = indexes
    index.messages.update({channel: len(one.records) for channel, one in indexes.items()})
    index.chunks.append(
        ChunkIndex(
            chunk_length=RECORD_HEADER.size + head.length,
            chunk_start_offset=head.start,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            message_end_time=chunk.message_end_time,
            message_index_length=0,
            message_index_offsets={},
            message_start_time=chunk.message_start_time,
            uncompressed_size=chunk.uncompressed_size,
        )
    )
