"""Chunks of an MCAP file: refused before they are decompressed unless a recorder wrote them; their messages by time."""

import struct
import zlib
from array import array
from collections.abc import Iterator, Set
from typing import Any, NamedTuple

import lz4.frame
import numpy as np
from mcap.opcode import Opcode

from common.recording.records import MOST_CHUNK_BYTES, MOST_TIME_NS, RECORD_HEADER

COMPRESSION = b"lz4"  # the recorders' own
CHUNK_HEAD = struct.Struct("<QQQII")  # first and last time, decompressed size, its CRC, the length of what follows
CONTENT_LENGTH = struct.Struct("<Q")
MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, number, time, when it was published


class ChunkRecord(NamedTuple):
    """A record of a chunk: its kind, and where its content is."""

    opcode: int
    begin: int
    end: int


class ChunkMessage(NamedTuple):
    """A message of a chunk; times in ns since the epoch of the file."""

    channel: int
    log_ns: int
    published_ns: int
    data: bytes


def decompressed(content: bytes) -> bytes:
    """The records of a chunk, at most 64 MB; ValueError for one that no recorder wrote, or that is damaged."""
    _, _, size, crc, length = CHUNK_HEAD.unpack_from(content)
    compression, begin = content[CHUNK_HEAD.size :][:length], CHUNK_HEAD.size + length
    if compression != COMPRESSION:
        said = compression[:16].decode(errors="replace") or "nothing"
        raise ValueError(f"a chunk compressed by {said!r}; recorders use {COMPRESSION.decode()}")
    if size > MOST_CHUNK_BYTES:
        raise ValueError(f"a chunk of {size >> 20} MB; recorders write at most {MOST_CHUNK_BYTES >> 20}")
    begin += CONTENT_LENGTH.size
    if CONTENT_LENGTH.unpack_from(content, begin - CONTENT_LENGTH.size)[0] != len(content) - begin:
        raise ValueError("a chunk that is not as long as it says")
    data = _expanded(content[begin:], size)
    if zlib.crc32(data) != crc:
        raise ValueError("a chunk whose check sum is wrong")
    return data


def _expanded(compressed: bytes, size: int) -> bytes:
    """Exactly `size` bytes, and no more memory than they take."""
    frame: Any = lz4.frame.LZ4FrameDecompressor()
    data: bytes = frame.decompress(compressed, max_length=size + 1)
    if len(data) != size or not frame.eof or frame.unused_data:
        raise ValueError("a chunk that does not have the size that it says")
    return data


def records_in(data: bytes) -> Iterator[ChunkRecord]:
    """The records of a decompressed chunk; ValueError where one is cut."""
    at = 0
    while at < len(data):
        opcode, length = RECORD_HEADER.unpack_from(data, at)
        begin = at + RECORD_HEADER.size
        at = begin + length
        if at > len(data):
            raise ValueError("a record that goes beyond its chunk")
        yield ChunkRecord(opcode, begin, at)


def messages_in(data: bytes, channels: Set[int], begin_ns: int, end_ns: int) -> Iterator[ChunkMessage]:
    """The messages of some channels of a decompressed chunk, by their times, then as they were written.

    From `begin_ns` on and before `end_ns`; ValueError for a record that is cut.
    """
    times, begins = array("Q"), array("Q")  # of small messages there may be millions
    for opcode, begin, end in records_in(data):
        if opcode != Opcode.MESSAGE:
            continue
        if end - begin < MESSAGE_HEAD.size:
            raise ValueError("a message without its head")
        channel, _, log_ns, published_ns = MESSAGE_HEAD.unpack_from(data, begin)
        if max(log_ns, published_ns) >= MOST_TIME_NS:
            raise ValueError("a message of no time that a recorder knows")
        if channel in channels and begin_ns <= log_ns < end_ns:
            times.append(log_ns)
            begins.append(begin)
    for begin in np.array(begins)[np.argsort(np.array(times), kind="stable")].tolist():
        yield _message(data, begin)


def _message(data: bytes, begin: int) -> ChunkMessage:
    _, length = RECORD_HEADER.unpack_from(data, begin - RECORD_HEADER.size)
    channel, _, log_ns, published_ns = MESSAGE_HEAD.unpack_from(data, begin)
    return ChunkMessage(channel, log_ns, published_ns, data[begin + MESSAGE_HEAD.size : begin + length])
