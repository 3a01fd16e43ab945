"""The records of an MCAP file, each read only once it fits the file, and what a recorder writes."""

import struct
from typing import IO, NamedTuple

from mcap.exceptions import McapError

MAGIC = b"\x89MCAP0\r\n"
RECORD_HEADER = struct.Struct("<BQ")
MOST_CHUNK_BYTES = 64 << 20  # decompressed; a recorder's have a quarter of it, and one message
MOST_RECORD_BYTES = MOST_CHUNK_BYTES + (1 << 20)  # what cannot be compressed grows a little
MOST_DESCRIBED_BYTES = 1 << 20  # schemas, channels and names of a file; a recorder's have some 50 kB
MOST_TABLE_BYTES = 64 << 10  # of one table of words
MOST_TIME_NS = 1 << 62  # since 1970: the year 2116; differences of two times fit into 64 bits
# What damage makes of a reader; lz4 raises RuntimeError.
BROKEN = (McapError, ValueError, RuntimeError, struct.error, EOFError, LookupError, OverflowError, MemoryError)


class RecordHead(NamedTuple):
    """A record's kind, where it begins, and the length of its content."""

    opcode: int
    start: int
    length: int

    @property
    def end(self) -> int:
        return self.start + RECORD_HEADER.size + self.length


def next_head(file: IO[bytes], start: int, size: int) -> RecordHead | None:
    """The record that begins there in a file of this size, None where it is cut."""
    file.seek(start)
    read = file.read(RECORD_HEADER.size)
    if len(read) < RECORD_HEADER.size:
        return None
    head = RecordHead(RECORD_HEADER.unpack(read)[0], start, RECORD_HEADER.unpack(read)[1])
    return head if head.end <= size else None


def content_of(file: IO[bytes], head: RecordHead) -> bytes:
    """Read what is in a record; ValueError for one that is larger than any that a recorder writes."""
    if head.length > MOST_RECORD_BYTES:
        raise ValueError(f"a record of {head.length >> 20} MB; a recorder writes at most {MOST_RECORD_BYTES >> 20}")
    file.seek(head.start + RECORD_HEADER.size)
    return file.read(head.length)


def record_at(file: IO[bytes], opcode: int, start: int, size: int) -> bytes:
    """Read the record of this kind that begins there; ValueError where the file has none."""
    head = next_head(file, start, size) if start < size else None
    if head is None or head.opcode != opcode:
        raise ValueError(f"its index names a record at byte {start}, where there is none")
    return content_of(file, head)


def check_described(size: int) -> None:
    """ValueError where all that describes a file takes more bytes than a recorder's."""
    if size > MOST_DESCRIBED_BYTES:
        raise ValueError(f"its schemas and names take more than {MOST_DESCRIBED_BYTES >> 20} MB, unlike a recorder's")
