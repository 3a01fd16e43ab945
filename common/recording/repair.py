"""Makes a file whole that was not ended in order: cut after its last whole chunk, and indexed again in place."""

import os
import shutil
import struct
import zlib
from pathlib import Path
from typing import IO, Any, NamedTuple

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import DataEnd, Footer, McapRecord, Statistics, SummaryOffset

from common.clock import NS_PER_S
from common.errors import RecordingError
from common.recording.mcap_file import OWNER_ONLY, is_being_written
from common.recording.scan import MAGIC, FileIndex, NotMcapError, ShowBytes, scan


class Repaired(NamedTuple):
    """What a repair found: messages and seconds that are whole, and the bytes that had to be cut; none if it was."""

    was_whole: bool
    messages: int
    seconds: float
    cut_bytes: int


def repair(path: Path, rest: Path | None = None, show: ShowBytes = lambda _done, _size: None) -> Repaired:
    """Repair a file in place; one that is whole stays as it is. What has to be cut goes to a new file `rest`, if given.

    `show` is called while the file is read. RecordingError where nothing of it is whole, or there is a file of the
    name of the rest.
    """
    try:
        with path.open("r+b") as file:
            return _repaired(path, file, rest, show)
    except FileExistsError as error:
        raise RecordingError(f"{path} cannot be repaired: {rest} is there already; move it away") from error
    except NotMcapError as error:
        raise RecordingError(f"{path} cannot be repaired: {error}") from error
    except OSError as error:
        raise RecordingError(f"{path} cannot be repaired: {error.strerror}; free some space, or its rights") from error


def _repaired(path: Path, file: IO[bytes], rest: Path | None, show: ShowBytes) -> Repaired:
    if is_being_written(file):
        raise RecordingError(f"{path} is being written: end the recording first")
    index = scan(file, show)
    messages = index.messages.total()
    first_ns = min((chunk.message_start_time for chunk in index.chunks), default=0)
    last_ns = max((chunk.message_end_time for chunk in index.chunks), default=0)
    seconds = (last_ns - first_ns) / NS_PER_S
    if index.is_finished:
        return Repaired(True, messages, seconds, 0)
    cut = os.fstat(file.fileno()).st_size - index.end
    if rest is not None and cut:
        if not messages:
            raise RecordingError(f"{path} cannot be repaired: not one second of it is whole at its beginning")
        _keep(file, index.end, rest)
    file.truncate(index.end)
    file.seek(index.end)
    file.write(_missing_indexes(index))
    file.write(_ending(index, file.tell()))
    file.flush()
    os.fsync(file.fileno())
    return Repaired(False, messages, seconds, cut)


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
    builder: Any = RecordBuilder()
    last = index.chunks[-1]
    for channel, missing in index.unindexed.items():
        last.message_index_offsets[channel] = index.end + builder.count
        missing.write(builder)
    last.message_index_length += builder.count
    return bytes(builder.end())


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
        message_start_time=min((chunk.message_start_time for chunk in index.chunks), default=0),
        message_end_time=max((chunk.message_end_time for chunk in index.chunks), default=0),
        schema_count=len(index.schemas),
    )


def _bytes_of(records: list[McapRecord]) -> bytes:
    builder: Any = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())
