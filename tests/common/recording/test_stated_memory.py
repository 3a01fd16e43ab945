"""What describes a recording, and its events, take no more memory than is stated, however little they compress to."""

import struct
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
from mcap.opcode import Opcode
from mcap.records import AttachmentIndex, Channel, Header, McapRecord, Metadata, MetadataIndex, Schema

from common.errors import RecordingError
from common.messages.recording import EpisodeOutcome
from common.recording.episodes import MOST_EPISODES, EpisodeEvent, EpisodeEventKind
from common.recording.hand_transcript import EPISODE
from common.recording.mcap_file import McapFile
from common.recording.reader import CLOCK_TABLE, EPOCH_KEY, RecordingReader
from common.recording.recorded_episodes import episodes_of, read_episodes
from common.recording.records import MAGIC
from common.recording.repair import repair
from tests.common.recording.damaged_files import (
    CHANNEL,
    chunk_of,
    forged,
    messages,
    read_all,
    row_of,
    statistics,
    takes_at_most,
    written,
)

MB = 1 << 20
NAME = "n" * 60_000
CHUNK = chunk_of(messages(1, 5))
CLOCK = Metadata(CLOCK_TABLE, {EPOCH_KEY: "0"})
NAMED: dict[str, list[McapRecord]] = {
    "topics": [Channel(k, f"{NAME}{k}", "x", {}, 0) for k in range(2, 202)],
    "tables": [MetadataIndex(8, 9, f"{NAME}{k}") for k in range(200)],
    "documents": [AttachmentIndex(8, 9, 0, 0, 9, f"{NAME}{k}", "") for k in range(200)],
    "one topic": [Channel(2, NAME * 200, "x", {}, 0)],
}


def begun(*records: McapRecord) -> bytes:
    """A file that was never ended."""
    return MAGIC + written(Header("farhand", "test"), *records)


@pytest.mark.parametrize("case", NAMED)
def test_names_that_would_take_memory_are_refused_and_a_repair_is_the_cure(case: str, tmp_path: Path) -> None:
    begin = len(begun(CLOCK))
    path = forged(tmp_path / "x.mcap", [CHUNK], [statistics(1, 1), row_of(CHUNK, begin), *NAMED[case]])
    with takes_at_most(3 * MB), pytest.raises(RecordingError, match=r"take more than 1 MB.*farhand record repair"):
        read_all(path)
    assert repair(path).messages == 1
    assert read_all(path) == 1


def test_a_table_larger_than_any_is_left_out_by_a_repair(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    words = {f"{k:07}": "" for k in range(100_000)}
    path.write_bytes(begun(CLOCK, Metadata("words", words), CHUNK))
    with takes_at_most(6 * MB):
        assert repair(path).messages == 1
    assert read_all(path) == 1
    with RecordingReader(path) as reader, pytest.raises(KeyError):
        reader.table("words")


def test_a_table_of_the_clock_larger_than_any_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    file = McapFile(path, "test")
    file.describe(CLOCK_TABLE, {EPOCH_KEY: "0"} | {f"{k:07}": "" for k in range(100_000)})
    file.finish()
    with takes_at_most(6 * MB), pytest.raises(RecordingError, match="a table of 1464 kB; recorders write at most 64"):
        read_all(path)


def test_a_repair_takes_no_more_schemas_than_a_recorder_writes(tmp_path: Path) -> None:
    """Zeros by lz4 are 250 times as many in the index, which has them as they are."""
    path = tmp_path / "x.mcap"
    schemas = [Schema(id=k + 1, data=bytes(600_000), encoding="jsonschema", name="n") for k in range(4)]
    path.write_bytes(begun(CLOCK, *(chunk_of(written(schema) + messages(1, 5)) for schema in schemas)))
    done = repair(path, tmp_path / "rest")
    assert (done.messages, read_all(path)) == (1, 1)
    assert done.cut_bytes == (tmp_path / "rest").stat().st_size > 0
    assert path.stat().st_size < MB


def test_schemas_and_topics_that_each_chunk_repeats_count_once(tmp_path: Path) -> None:
    path, count = tmp_path / "x.mcap", 24
    schema = Schema(id=1, data=bytes(100_000), encoding="jsonschema", name="n")
    topic = Channel(2, "t" * 100_000, "x", {}, 1)
    path.write_bytes(begun(CLOCK, *[chunk_of(written(schema, topic) + messages(1, 5))] * count))
    assert repair(path).messages == read_all(path) == count


@pytest.mark.slow
def test_as_much_as_a_repair_takes_a_reader_takes_too(tmp_path: Path) -> None:
    """The index has a count for each topic, beside what describes it."""
    path, count = tmp_path / "x.mcap", 43_000
    topics = written(*(Channel(k, f"t{k:05}", "x", {}, 0) for k in range(count)))
    assert 0.9 * MB < len(topics) - 9 * count < MB
    told = b"".join(struct.pack("<BQHIQQ", Opcode.MESSAGE, 22, k, 0, 1, 1) for k in range(count))
    path.write_bytes(begun(CLOCK, chunk_of(topics + told)))
    assert repair(path).messages == read_all(path) == count


def test_a_repair_reads_no_rows_of_a_message_index(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    rows = bytes(16 * 250_000)
    index = struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6 + len(rows), CHANNEL.id, len(rows)) + rows
    path.write_bytes(begun(CLOCK, CHUNK) + index)
    with takes_at_most(16 * MB):
        assert repair(path).messages == 1


def event(episode: int, note: str = "") -> EpisodeEvent:
    kind, outcome = EpisodeEventKind.LABEL, EpisodeOutcome.UNKNOWN
    return EpisodeEvent(event=kind, episode=episode, t_ns=1, by="anna", task="", outcome=outcome, note=note)


def with_events(path: Path, events: Iterator[EpisodeEvent]) -> Path:
    file = McapFile(path, "test")
    file.describe(CLOCK_TABLE, {EPOCH_KEY: "0"})
    for k, one in enumerate(events):
        file.add(EPISODE, msgspec.json.encode(one), k + 1, k + 1)
        if k % 1000 == 999:
            file.flush()
    file.finish()
    return path


def test_of_thousands_of_events_of_one_episode_only_the_last_is_kept(tmp_path: Path) -> None:
    path = with_events(tmp_path / "x.mcap", (event(1, f"{k:4000}") for k in range(6000)))
    assert path.stat().st_size < MB
    with takes_at_most(12 * MB):
        (episode,) = read_episodes([path])
    assert episode.note.strip() == "5999"


def test_more_or_longer_events_than_any_recording_has_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="more than 10000 episodes"):
        episodes_of(event(k) for k in range(MOST_EPISODES + 1))
    path = with_events(tmp_path / "x.mcap", iter([event(1, "n" * 9000)]))
    with pytest.raises(RecordingError, match="an event of 8 kB"):
        read_episodes([path])
