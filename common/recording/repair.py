"""Makes a file whole that was not ended in order: cut after its last whole chunk, and indexed again in place."""

import errno
import os
import shutil
import struct
import zlib
from collections import deque
from io import BytesIO
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import DataEnd, Footer, McapRecord, Metadata, Statistics, SummaryOffset

from common.atomic_file import OWNER_ONLY
from common.clock import NS_PER_S
from common.errors import RecordingError
from common.recording.mcap_file import is_being_written
from common.recording.reader import CLOCK_TABLE, epoch_in
from common.recording.records import BROKEN, MAGIC, record_at
from common.recording.scan import FileIndex, ShowBytes, scan
from common.recording.summary import ChunkPlace, FileSummary, check_chunks, check_span, read_summary

RIGHTS = "repair it as the user whose file it is: its folder must take a file too"
CURES = {
    errno.ENOENT: "give the path of a recording",
    errno.ENOTDIR: "give the path of a recording",
    errno.EISDIR: "give the path of a recording, as FOLDER/*.mcap",
    errno.ENOSPC: "free some space there",
    errno.EDQUOT: "free some space there",
    errno.EACCES: RIGHTS,
    errno.EPERM: RIGHTS,
    errno.EROFS: "copy it to a disk that can be written, and repair it there",
}
MESSAGE_INDEX = struct.Struct("<BQHI")  # a record's head, its channel, and the length of the rows that follow


class Repaired(NamedTuple):
    """The outcome of a repair: messages and seconds that are whole, and the bytes that were cut, 0 if none were."""

    was_whole: bool
    messages: int
    seconds: float
    cut_bytes: int


def repair(path: Path, rest: Path | None = None, show: ShowBytes = lambda _done, _size: None) -> Repaired:
    """Repair a file in place; one that is whole stays as it is. What has to be cut goes to a new file `rest`, if given.

    `show` is called while the file is read. RecordingError, and the file stays as it is, where nothing of it is whole,
    a reader would refuse what is, or there is a file of the name of the rest.
    """
    try:
        with path.open("r+b") as file:
            return _repaired(path, file, rest, show)
    except FileExistsError as error:
        raise RecordingError(f"{path} cannot be repaired: {rest} is there already; move it away") from error
    except OSError as error:
        cure = CURES.get(error.errno or 0, "copy it to another disk, and repair it there")
        raise RecordingError(f"{path} cannot be repaired: {error.strerror}; {cure}") from error
    except BROKEN as error:
        cure = "get it again from where it was recorded"
        raise RecordingError(f"{path} cannot be repaired: {error or type(error).__name__}; {cure}") from error


def _repaired(path: Path, file: IO[bytes], rest: Path | None, show: ShowBytes) -> Repaired:
    if is_being_written(file):
        raise RecordingError(f"{path} is being written: end the recording first")
    index = scan(file, show)
    if (whole := _whole(file, index)) is not None:
        return Repaired(True, whole.count, _seconds(whole.span_ns), 0)
    cut = os.fstat(file.fileno()).st_size - index.end
    if rest is not None and cut and not index.chunks:
        raise RecordingError(f"{path} cannot be repaired: not one second of it is whole at its beginning")
    _check_readable(file, index)
    if rest is not None and cut:
        _keep(file, index.end, rest)
    file.truncate(index.end)
    file.seek(index.end)
    file.write(_missing_indexes(index))
    file.write(_ending(index, file.tell()))
    file.flush()
    if _whole(file, index) is None:
        raise RecordingError(f"{path} is not repaired: its new index cannot be read; copy it to another disk first")
    os.fsync(file.fileno())
    return Repaired(False, index.messages.total(), _seconds(index.span_ns), cut)


def _seconds(span_ns: tuple[int, int]) -> float:
    return (span_ns[1] - span_ns[0]) / NS_PER_S


def _whole(file: IO[bytes], index: FileIndex) -> FileSummary | None:
    """The summary of a file that a reader opens, with each table, document and chunk that it names; else None."""
    try:
        summary = read_summary(file)
        for name in summary.documents:
            summary.document(file, name)
        for name in summary.tables:
            summary.table(file, name)
        epoch_in(summary.table(file, CLOCK_TABLE))
        found = [place._replace(channels=b"") for place in summary.chunks]
        if summary.count != index.messages.total() or found != _places(index):
            for place in summary.chunks:  # does a reader pass over the damage that ended the scan?
                deque(summary.messages_of(file, place, summary.topics.keys()), maxlen=0)
    except BROKEN:
        return None
    return summary


def _places(index: FileIndex) -> list[ChunkPlace]:
    return [
        ChunkPlace(c.message_start_time, c.message_end_time, c.chunk_start_offset, c.uncompressed_size, b"")
        for c in index.chunks
    ]


def _check_readable(file: IO[bytes], index: FileIndex) -> None:
    """RecordingError or ValueError where a reader would refuse what is whole of a file."""
    check_chunks(_places(index), index.end)
    check_span(*index.span_ns)
    found = next((row for row in index.metadata if row.name == CLOCK_TABLE), None)
    if found is None:
        raise ValueError("its table of the clock is missing or damaged, so that no message of it has a time")
    epoch_in(Metadata.read(ReadDataStream(BytesIO(record_at(file, Opcode.METADATA, found.offset, index.end)))).metadata)


def _keep(file: IO[bytes], begin: int, rest: Path) -> None:
    """Copy the file from a byte on."""
    file.seek(begin)
    with rest.open("xb") as kept:
        rest.chmod(OWNER_ONLY)
        shutil.copyfileobj(file, kept)


def _missing_indexes(index: FileIndex) -> bytes:
    """The message indexes that the last chunk lacks; the summary then knows them."""
    if not index.chunks:
        return b""
    written, last = b"", index.chunks[-1]
    for channel, places in index.unindexed.items():
        last.message_index_offsets[channel] = index.end + len(written)
        rows = np.array(places, "<u8").tobytes()
        written += MESSAGE_INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(rows), channel, len(rows)) + rows
    last.message_index_length += len(written)
    return written


def _ending(index: FileIndex, start: int) -> bytes:
    """The end of the data, the summary, and the footer of a file that ends at `start` without them."""
    data_end = _bytes_of([DataEnd(0)])
    summary_start = start + len(data_end)
    groups: dict[Opcode, list[McapRecord]] = {
        Opcode.SCHEMA: [*index.schemas.values()],
        Opcode.CHANNEL: [*index.channels.values()],
        Opcode.STATISTICS: [_statistics(index)],
        Opcode.CHUNK_INDEX: [*index.chunks],
        Opcode.ATTACHMENT_INDEX: [*index.attachments],
        Opcode.METADATA_INDEX: [*index.metadata],
    }
    summary, offsets = b"", []
    for opcode, records in groups.items():
        written = _bytes_of(records)
        offsets.append(
            SummaryOffset(group_opcode=opcode, group_start=summary_start + len(summary), group_length=len(written))
        )
        summary += written
    offsets_start = summary_start + len(summary)
    summary += _bytes_of([*offsets])
    places = struct.pack("<BQQQ", Opcode.FOOTER, 20, summary_start, offsets_start)
    footer = Footer(
        summary_start=summary_start,
        summary_offset_start=offsets_start,
        summary_crc=zlib.crc32(places, zlib.crc32(summary)),
    )
    return data_end + summary + _bytes_of([footer]) + MAGIC


def _statistics(index: FileIndex) -> Statistics:
    return Statistics(
        attachment_count=len(index.attachments),
        channel_count=len(index.channels),
        channel_message_counts=dict(index.messages),
        chunk_count=len(index.chunks),
        message_count=index.messages.total(),
        metadata_count=len(index.metadata),
        message_start_time=index.span_ns[0],
        message_end_time=index.span_ns[1],
        schema_count=len(index.schemas),
    )


def _bytes_of(records: list[McapRecord]) -> bytes:
    builder: Any = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())
