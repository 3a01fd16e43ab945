"""A recording's file: its owner's alone, whole to the last flush wherever it is cut, and open to others' readers."""

import os
import stat
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from mcap.reader import NonSeekingReader, make_reader
from structlog.testing import capture_logs

from common.errors import RecordingError
from common.recording.hand_transcript import EPISODE, LOG
from common.recording.mcap_file import MOST_CHUNK_BYTES, McapFile
from common.recording.reader import CLOCK_TABLE, EPOCH_KEY, RecordingReader
from common.recording.records import MAGIC
from common.recording.repair import repair
from common.recording.topics import JSON, MSGPACK, MessageSchema, Topic, protobuf_topic, wire_topic

A = Topic("a", MSGPACK, MessageSchema("farhand.A"), {"unit": "m"})
B = Topic("b", JSON, MessageSchema("B", "jsonschema", b'{"type":"object"}'))
SECOND_NS = 10**9
PER_FLUSH = 3


def unfinished(path: Path, flushes: int = 3) -> McapFile:
    """A file with a message of each topic at three times a second, flushed each second; b comes one second later."""
    file = McapFile(path, "test")
    file.describe(CLOCK_TABLE, {EPOCH_KEY: "1000"})
    file.attach("notes.txt", "text/plain", b"attached", 0)
    for second in range(flushes):
        for k in range(PER_FLUSH):
            t_ns = second * SECOND_NS + k
            file.add(A, f"a{second}{k}".encode() * 20, t_ns + 1000, t_ns + 1000)
            if second:
                file.add(B, b"{}", t_ns + 1000, t_ns + 990)
        file.flush()
    return file


def texts(path: Path) -> list[bytes]:
    with RecordingReader(path) as reader:
        return [message.data[:3] for message in reader.messages(["a"])]


def expected(seconds: int) -> list[bytes]:
    return [f"a{second}{k}".encode() for second in range(seconds) for k in range(PER_FLUSH)]


def test_only_its_owner_may_read_it(tmp_path: Path) -> None:
    os.umask(0o022)
    unfinished(tmp_path / "file.mcap").finish()
    assert stat.S_IMODE((tmp_path / "file.mcap").stat().st_mode) == 0o600


def test_no_file_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "file.mcap").write_bytes(b"kept")
    with pytest.raises(FileExistsError):
        McapFile(tmp_path / "file.mcap", "test")


def test_what_was_written_is_read_with_its_times(tmp_path: Path) -> None:
    path = tmp_path / "file.mcap"
    unfinished(path).finish()
    with RecordingReader(path) as reader:
        assert reader.topics == {"a": 9, "b": 6}
        assert reader.document("notes.txt") == b"attached"
        last = list(reader.messages())[-1]
    assert (last.topic, last.t_ns, last.published_ns) == ("b", 2 * SECOND_NS + 2, 2 * SECOND_NS - 8)
    assert texts(path) == expected(3)


def test_who_reads_events_reads_nothing_else_and_all_come_in_the_order_of_their_times(tmp_path: Path) -> None:
    path, picture = tmp_path / "file.mcap", protobuf_topic("/camera/side", CompressedImage)
    file = McapFile(path, "test")
    file.describe(CLOCK_TABLE, {EPOCH_KEY: "0"})
    topics = [picture, A, LOG, EPISODE]
    for t_ns in range(1, 53):
        file.add(topics[t_ns % len(topics)], f"{t_ns}".encode(), t_ns, t_ns)
        if t_ns % 13 == 0:
            file.flush()
    file.finish()
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    in_chunks = [{summary.channels[k].topic for k in chunk.message_index_offsets} for chunk in summary.chunk_indexes]
    groups = [{picture.name}, {A.name}, {LOG.name, EPISODE.name}]
    assert len(in_chunks) == 4 * len(groups)
    assert all(topics in groups for topics in in_chunks)
    with RecordingReader(path) as reader:
        assert [message.t_ns for message in reader.messages()] == list(range(1, 53))
        assert {int(message.data) for message in reader.messages([EPISODE.name])} == set(range(3, 53, 4))


def test_a_file_whose_flushes_are_late_has_chunks_of_bounded_size(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "file.mcap", "test")
    for k in range(5):
        file.add(A, os.urandom(MOST_CHUNK_BYTES // 4), k, k)
    assert MOST_CHUNK_BYTES < file.size < 1.2 * MOST_CHUNK_BYTES
    file.close()


@pytest.mark.slow
def test_a_file_cut_at_any_byte_is_whole_to_its_last_flush(tmp_path: Path) -> None:
    whole = tmp_path / "whole.mcap"
    file, ends = unfinished(whole, 0), []
    for second in range(3):
        for k in range(PER_FLUSH):
            file.add(A, f"a{second}{k}".encode(), second * SECOND_NS + k + 1000, 0)
        file.flush()
        ends.append(file.size)
    file.finish()
    data, cut = whole.read_bytes(), tmp_path / "cut.mcap"
    indexes = 200  # behind each chunk: without them it is whole, too
    seen = set()
    for length in range(unfinished(tmp_path / "empty.mcap", 0).size, len(data)):
        cut.write_bytes(data[:length])
        repair(cut)
        with cut.open("rb") as stream:
            found = [message.data[:3] for _, _, message in make_reader(stream).iter_messages()]
        with cut.open("rb") as stream:
            assert found == [message.data[:3] for _, _, message in NonSeekingReader(stream).iter_messages()]
        seconds = len(found) // PER_FLUSH
        assert found == expected(seconds)
        assert sum(end <= length for end in ends) <= seconds <= sum(end - indexes <= length for end in ends)
        seen.add(seconds)
    assert seen == {0, 1, 2, 3}


@pytest.mark.parametrize(("names", "length"), [(30_000, 32), (100, 60_000)])
def test_names_without_end_leave_the_file_readable_and_are_said_once(tmp_path: Path, names: int, length: int) -> None:
    path = tmp_path / "file.mcap"
    file = unfinished(path)
    with capture_logs() as said:
        for k in range(names):
            invented = wire_topic(f"farhand/lab/hand/{k:0{length}}", "HandArm", 15)
            file.add(invented, b"sample", 3 * SECOND_NS + k, 3 * SECOND_NS + k)
            if k % (names // 10) == 0:
                file.add(A, b"a30", 3 * SECOND_NS + k, 3 * SECOND_NS + k)
                file.flush()
    file.finish()
    with RecordingReader(path) as reader:
        topics = reader.topics
    assert topics["a"] == 9 + 10
    assert 2 < len(topics) < names / 2
    assert list(topics.values())[2:] == [1] * (len(topics) - 2)
    assert [line["event"] for line in said] == ["a recording takes no more topics"]


def test_a_killed_writer_loses_only_what_came_since_the_last_flush(tmp_path: Path) -> None:
    path = tmp_path / "file.mcap"
    child = os.fork()
    if child == 0:
        file = unfinished(path)
        file.add(A, b"not flushed", 3 * SECOND_NS, 3 * SECOND_NS)
        os.kill(os.getpid(), 9)
    os.waitpid(child, 0)
    with pytest.raises(RecordingError, match="farhand record repair"):
        RecordingReader(path)
    done = repair(path)
    assert not done.was_whole
    assert done.messages == 15
    assert done.seconds == pytest.approx(2.0)
    assert texts(path) == expected(3)


def test_a_repaired_file_is_like_one_that_was_ended(tmp_path: Path) -> None:
    ended, killed = tmp_path / "ended.mcap", tmp_path / "killed.mcap"
    unfinished(ended).finish()
    unfinished(killed).close()
    repair(killed)
    assert ended.read_bytes() == killed.read_bytes()


def test_a_whole_file_is_left_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "file.mcap"
    unfinished(path).finish()
    before = path.read_bytes()
    assert repair(path).was_whole
    assert path.read_bytes() == before


def test_a_spoiled_byte_costs_no_chunk_before_it(tmp_path: Path) -> None:
    path = tmp_path / "file.mcap"
    unfinished(path).close()
    data = bytearray(path.read_bytes())
    data[data.rindex(b"a22")] ^= 1
    path.write_bytes(data)
    repair(path)
    assert texts(path) == expected(2)


def test_a_file_that_is_being_written_is_not_repaired(tmp_path: Path) -> None:
    file = unfinished(tmp_path / "file.mcap")
    with pytest.raises(RecordingError, match="end the recording first"):
        repair(tmp_path / "file.mcap")
    file.finish()


def test_a_file_that_is_being_written_is_not_read_and_no_repair_is_advised(tmp_path: Path) -> None:
    file = unfinished(tmp_path / "file.mcap")
    with pytest.raises(RecordingError, match="is being recorded: end the recording first"):
        RecordingReader(tmp_path / "file.mcap")
    file.finish()
    assert texts(tmp_path / "file.mcap") == expected(3)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "no recording"),
        (b"[task]\nname = 1\n", "no recording"),
        (MAGIC + b"\0" * 60, "its end is missing.*repair"),
    ],
)
def test_what_is_no_recording_is_told_apart_from_one_that_was_cut(tmp_path: Path, content: bytes, told: str) -> None:
    (tmp_path / "file.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match=told):
        RecordingReader(tmp_path / "file.mcap")


def test_other_files_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "other").write_bytes(b"nothing of the kind")
    with pytest.raises(RecordingError, match="does not begin"):
        repair(tmp_path / "other")
    assert (tmp_path / "other").read_bytes() == b"nothing of the kind"
