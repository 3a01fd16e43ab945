"""Small recordings, and what damage or malice makes of them: changed bytes, cut files, chunks and indexes that lie."""

import random
import struct
import tracemalloc
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import lz4.frame
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, Footer, Header, McapRecord, Metadata, MetadataIndex, Statistics

from common.recording.mcap_file import McapFile
from common.recording.reader import CLOCK_TABLE, EPOCH_KEY, RecordingReader
from common.recording.records import MAGIC
from common.recording.topics import JSON, MSGPACK, MessageSchema, Topic

A = Topic("a", MSGPACK, MessageSchema("farhand.A"), {"unit": "m"})
B = Topic("b", JSON, MessageSchema("B", "jsonschema", b'{"type":"object"}'))
SECOND_NS = 10**9
DOCUMENT = "notes.txt"
MESSAGES = 42
CHANNEL = Channel(1, "a", "x", {}, 0)


@contextmanager
def takes_at_most(size: int) -> Iterator[None]:
    """Whether so many bytes are enough."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < size
    finally:
        tracemalloc.stop()


def recording(path: Path) -> bytes:
    """Four seconds of two topics, with a table and a document."""
    file = McapFile(path, "test")
    file.describe(CLOCK_TABLE, {EPOCH_KEY: "1000"})
    file.attach(DOCUMENT, "text/plain", b"attached" * 20, 0)
    for second in range(4):
        for k in range(6):
            t_ns = second * SECOND_NS + k + 2000
            file.add(A, f"a{second}{k}".encode() * 20, t_ns, t_ns)
            if second:
                file.add(B, b"{}", t_ns, t_ns)
        file.flush()
    file.finish()
    return path.read_bytes()


def read_all(path: Path) -> int:
    """Read everything of a file; how many messages it has."""
    with RecordingReader(path) as reader:
        assert reader.seconds >= 0.0
        with suppress(KeyError):  # it never had one, or a repair left it out
            reader.document(DOCUMENT)
        return sum(1 for _ in reader.messages())


def changed(whole: bytes, seed: int) -> Iterator[bytes]:
    """Endlessly: one or two bytes changed; one time in four the file is cut before, and up to four bytes changed."""
    chance = random.Random(seed)  # noqa: S311  # for a test
    while True:
        is_cut = chance.random() < 0.25
        data = bytearray(whole[: chance.randrange(8, len(whole))] if is_cut else whole)
        for _ in range(chance.choice((0, 1, 2, 4) if is_cut else (1, 2))):
            data[chance.randrange(len(data))] = chance.randrange(256)
        yield bytes(data)


def written(*records: McapRecord) -> bytes:
    """Records as they are in a file."""
    builder: Any = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())


def forged(
    path: Path, chunks: Sequence[Chunk], rows: Sequence[McapRecord] | None = None, *, repeats: int = 1, count: int = 1
) -> Path:
    """A file of these chunks whose check sums are right; `rows` of its index, else each chunk `repeats` times."""
    data = MAGIC + written(Header("farhand", "test"))
    table = Metadata(CLOCK_TABLE, {EPOCH_KEY: "0"})
    places = [MetadataIndex(offset=len(data), length=0, name=CLOCK_TABLE)]
    data += written(table)
    index: list[McapRecord] = [statistics(1, 2, count)]
    for chunk in chunks:
        index += [row_of(chunk, len(data))] * repeats
        data += written(chunk)
    return ended(path, data, [CHANNEL, *places, *(index if rows is None else rows)])


def ended(path: Path, data: bytes, summary: Sequence[McapRecord]) -> Path:
    """The file with the summary of these records, and a footer whose check sum is right."""
    index = written(*summary)
    crc = zlib.crc32(index + struct.pack("<BQQQ", Opcode.FOOTER, 20, len(data), 0))
    path.write_bytes(data + index + written(Footer(len(data), 0, crc)) + MAGIC)
    return path


def statistics(begin_ns: int, end_ns: int, count: int = 1) -> Statistics:
    """Of a file whose messages are of these times."""
    return Statistics(
        attachment_count=0,
        channel_count=1,
        channel_message_counts={1: count},
        chunk_count=1,
        message_count=count,
        message_end_time=end_ns,
        message_start_time=begin_ns,
        metadata_count=1,
        schema_count=0,
    )


def row_of(chunk: Chunk, start: int) -> ChunkIndex:
    """The row of an index for a chunk that begins there."""
    return ChunkIndex(
        chunk_length=0,
        chunk_start_offset=start,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        message_end_time=chunk.message_end_time,
        message_index_length=0,
        message_index_offsets={1: 0},
        message_start_time=chunk.message_start_time,
        uncompressed_size=chunk.uncompressed_size,
    )


def chunk_of(data: bytes, compression: str = "lz4", size: int | None = None, compressed: bytes | None = None) -> Chunk:
    """A chunk of these records, or of what is `compressed`; `size` is what it says of itself."""
    return Chunk(
        compression=compression,
        data=lz4.frame.compress(data) if compressed is None else compressed,
        message_start_time=1,
        message_end_time=1_000_000,
        uncompressed_crc=zlib.crc32(data),
        uncompressed_size=len(data) if size is None else size,
    )


def messages(count: int, size: int, first_ns: int = 1) -> bytes:
    """Records of a channel and so many messages of zeros, their times from `first_ns` on."""
    head = struct.Struct("<BQHIQQ")
    rows = (head.pack(Opcode.MESSAGE, 22 + size, 1, 0, first_ns + k, 0) + bytes(size) for k in range(count))
    return written(CHANNEL) + b"".join(rows)


def zeros_by_zstd(size: int) -> bytes:
    """A frame of zstd that expands to so many zeros: 4 bytes for 128 kB."""
    block = 1 << 17
    count = size // block
    rows = (int.to_bytes(block << 3 | 1 << 1 | (k == count - 1), 3, "little") + b"\0" for k in range(count))
    return b"\x28\xb5\x2f\xfd" + b"\x00\x38" + b"".join(rows)
