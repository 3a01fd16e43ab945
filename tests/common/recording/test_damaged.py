"""A damaged or hostile recording is refused or repaired, within a stated memory, and never ends its reader."""

import subprocess
import sys
from itertools import islice
from pathlib import Path

import pytest
import zstandard
from mcap.records import AttachmentIndex, MetadataIndex

from common.errors import RecordingError
from common.recording.reader import RecordingReader
from common.recording.records import MOST_CHUNK_BYTES
from common.recording.repair import repair
from tests.common.recording.damaged_files import (
    DOCUMENT,
    MESSAGES,
    changed,
    chunk_of,
    forged,
    messages,
    read_all,
    recording,
    row_of,
    statistics,
    takes_at_most,
    zeros_by_zstd,
)

MB = 1 << 20
STATED_MB = 512  # docs/recording.md
CASES = 200


def test_whatever_is_changed_or_cut_it_is_read_or_refused_and_what_is_repaired_can_be_read(
    tmp_path: Path,
) -> None:
    path, ends = tmp_path / "x.mcap", {"read": 0, "refused": 0, "repaired": 0, "not repaired": 0}
    for data in islice(changed(recording(tmp_path / "whole.mcap"), seed=15), CASES):
        path.write_bytes(data)
        try:
            found = read_all(path)
            ends["read"] += 1
        except RecordingError:
            found = 0
            ends["refused"] += 1
        try:
            done = repair(path)
        except RecordingError:
            ends["not repaired"] += 1
            assert path.read_bytes() == data
            continue
        ends["repaired"] += 1
        assert read_all(path) == done.messages >= found
    assert min(ends.values()) >= 3
    assert ends["repaired"] > CASES / 2


def test_what_a_reader_passes_over_is_no_reason_to_cut_a_file(tmp_path: Path) -> None:
    """The lengths in a message index, which no reader of ours uses."""
    path = tmp_path / "x.mcap"
    data = bytearray(recording(path))
    with RecordingReader(path):
        at = data.index(b"\x07", data.index(b"\x06")) + 9
    data[at + 2 : at + 6] = b"\xff" * 4
    path.write_bytes(data)
    assert read_all(path) == MESSAGES
    done = repair(path)
    assert (done.was_whole, done.messages) == (True, MESSAGES)
    assert path.read_bytes() == data


def test_a_damaged_document_is_left_out_by_a_repair_and_the_rest_kept(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    data = bytearray(recording(path))
    data[data.index(b"attached") + 3] ^= 1
    path.write_bytes(data)
    with RecordingReader(path) as reader, pytest.raises(RecordingError, match=r"'notes.txt' is damaged.*record repair"):
        reader.document(DOCUMENT)
    assert repair(path).messages == MESSAGES
    assert read_all(path) == MESSAGES


def test_a_damaged_index_is_made_anew(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    data = recording(path)
    path.write_bytes(data[:-40] + bytes([data[-40] ^ 1]) + data[-39:])
    with pytest.raises(RecordingError, match=r"check sum of its index is wrong.*farhand record repair"):
        read_all(path)
    assert not repair(path).was_whole
    assert read_all(path) == MESSAGES


LYING = {
    "another compression": (
        [chunk_of(b"", "zstd", 9, zeros_by_zstd(10_500 * MB))],
        "compressed by 'zstd'; recorders use lz4",
    ),
    "none": ([chunk_of(b"", "", 0, b"")], "compressed by 'nothing'"),
    "more than it says": ([chunk_of(bytes(42 * MB), size=1000)], "does not have the size that it says"),
    "less than it says": ([chunk_of(bytes(1000), size=1001)], "does not have the size that it says"),
    "larger than any": ([chunk_of(bytes(MOST_CHUNK_BYTES + 1))], "a chunk of 64 MB at byte"),
    "cut inside": ([chunk_of(b"\x05" + (99).to_bytes(8, "little"))], "a record that goes beyond its chunk"),
    "a message without head": ([chunk_of(b"\x05" + (3).to_bytes(8, "little") + b"abc")], "a message without its head"),
    "of no time": ([chunk_of(messages(1, 1, 2**63))], "a message of no time that a recorder knows"),
}


@pytest.mark.parametrize("case", LYING)
def test_a_chunk_that_no_recorder_wrote_is_refused_before_it_takes_memory(case: str, tmp_path: Path) -> None:
    chunks, why = LYING[case]
    path = forged(tmp_path / "x.mcap", chunks)
    with takes_at_most(4 * MB):
        with pytest.raises(RecordingError, match=why):
            read_all(path)
        with pytest.raises(RecordingError, match="cannot be repaired: not one second of it is whole"):
            repair(path, tmp_path / "rest")


def test_an_index_that_says_another_time_is_refused_and_made_anew(tmp_path: Path) -> None:
    path = forged(tmp_path / "x.mcap", [chunk_of(messages(1, 1, 2_000_000))])
    with pytest.raises(RecordingError, match="a message of another time than its index says"):
        read_all(path)
    assert not repair(path).was_whole
    assert read_all(path) == 1


def test_the_bomb_is_one(tmp_path: Path) -> None:
    frame = zeros_by_zstd(16 * MB)
    assert zstandard.ZstdDecompressor().decompress(frame, max_output_size=16 * MB) == bytes(16 * MB)
    assert forged(tmp_path / "x.mcap", LYING["another compression"][0]).stat().st_size < 400_000


def test_small_chunks_of_one_time_are_not_opened_all_at_once(tmp_path: Path) -> None:
    """164 kB of zeros by lz4 are 38 MB, and an index can name them again and again."""
    zeros = chunk_of(messages(1, 38 * MB))
    assert len(zeros.data) < 170_000
    with pytest.raises(RecordingError, match=r"an index that names a chunk twice.*farhand record repair"):
        read_all(forged(tmp_path / "x.mcap", [zeros], repeats=250))
    several = forged(tmp_path / "y.mcap", [zeros] * 4)
    with pytest.raises(RecordingError, match="152 MB of it are of one time; at most 128 are read"):
        read_all(several)
    with pytest.raises(RecordingError, match="cannot be repaired: 152 MB of it are of one time"):
        repair(several)


CHUNK = chunk_of(messages(1, 5))
ROWS = {
    "a chunk beyond the file": (row_of(CHUNK, 10**12), "a chunk of 0 MB at byte 1000000000000"),
    "no chunk there": (row_of(CHUNK, 20), "its index names a record at byte 20, where there is none"),
    "times before the end": (statistics(9, 8), "times that are no recording's"),
    "a month": (statistics(0, 32 * 24 * 3600 * 10**9), "a month is the longest"),
    "no year": (statistics(2**63, 2**63), "times that are no recording's"),
    "a document beyond the file": (AttachmentIndex(2**60, 9, 0, 0, 9, DOCUMENT, ""), "where there is none"),
    "a table that is a document": (MetadataIndex(8, 9, DOCUMENT), None),
}


@pytest.mark.parametrize("case", ROWS)
def test_an_index_that_does_not_fit_its_file_is_refused(case: str, tmp_path: Path) -> None:
    row, why = ROWS[case]
    path = forged(tmp_path / "x.mcap", [CHUNK], [statistics(1, 2), row])
    if why is None:
        with RecordingReader(path) as reader, pytest.raises(RecordingError, match="where there is none"):
            reader.table(DOCUMENT)
        return
    with pytest.raises(RecordingError, match=why):
        read_all(path)


def test_a_record_longer_than_any_is_not_read_into_memory(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    data = recording(path)
    with path.open("wb") as file:
        file.write(data[:-200] + b"\x0b" + (1 << 34).to_bytes(8, "little"))
        file.truncate(len(data) + (1 << 34))  # a hole: no disk
    with pytest.raises(RecordingError, match="its end is missing"):
        read_all(path)
    with takes_at_most(4 * MB):
        assert repair(path).messages == MESSAGES
    assert read_all(path) == MESSAGES


IN_A_CHILD = """
import resource, sys
from pathlib import Path
from tests.common.recording.damaged_files import read_all
from common.recording.repair import repair
pages = int(Path("/proc/self/statm").read_text().split()[0])
most = pages * resource.getpagesize() + int(sys.argv[2]) * (1 << 20)
resource.setrlimit(resource.RLIMIT_AS, (most, most))
path = Path(sys.argv[1])
print(read_all(path), repair(path).messages, read_all(path))
"""


@pytest.mark.slow
def test_the_largest_that_is_read_takes_no_more_memory_than_is_stated(tmp_path: Path) -> None:
    count = MOST_CHUNK_BYTES // (31 + 9000)
    path = forged(tmp_path / "x.mcap", [chunk_of(messages(count, 9000))] * 2, count=2 * count)
    told = subprocess.run(
        [sys.executable, "-c", IN_A_CHILD, str(path), str(STATED_MB)], capture_output=True, text=True, check=False
    )
    assert told.stdout.split() == [str(2 * count)] * 3, told.stderr
