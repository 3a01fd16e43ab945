"""What a repair cuts is kept beside the file, and a file of which nothing is whole stays as it is."""

import errno
import os
import re
from contextlib import nullcontext

import pytest
from typer.testing import CliRunner

from common.errors import RecordingError
from common.recording.mcap_file import McapFile
from common.recording.reader import CLOCK_TABLE, EPOCH_KEY
from common.recording.repair import repair
from common.recording.topics import MSGPACK, MessageSchema, Topic
from farhand.cli import app

TOPIC = Topic("/things", MSGPACK, MessageSchema("farhand.Thing"))
SECOND_NS = 10**9


@pytest.fixture
def file(tmp_path):
    """Four seconds, ended in order."""
    path = tmp_path / "run.mcap"
    writer = McapFile(path, "test")
    writer.describe(CLOCK_TABLE, {EPOCH_KEY: "0"})
    for second in range(4):
        for k in range(50):
            t_ns = second * SECOND_NS + k * SECOND_NS // 50 + 1
            writer.add(TOPIC, bytes([second, k]) * 100, t_ns, t_ns)
        writer.flush()
    writer.finish()
    return path


def cut(path, share):
    whole = path.read_bytes()
    path.write_bytes(whole[: round(share * len(whole))])
    return path.read_bytes()


def test_what_is_cut_is_in_the_rest(file, tmp_path):
    before = cut(file, 0.55)
    done = repair(file, tmp_path / "rest")
    rest = (tmp_path / "rest").read_bytes()
    assert len(rest) == done.cut_bytes > 0
    assert before.endswith(rest)
    assert file.read_bytes()[: len(before) - len(rest)] == before[: -len(rest)]
    assert (tmp_path / "rest").stat().st_mode & 0o077 == 0


def test_a_file_of_which_nothing_is_whole_stays_as_it_is(file, tmp_path):
    before = cut(file, 0.05)
    with pytest.raises(RecordingError, match="not one second of it is whole"):
        repair(file, tmp_path / "rest")
    assert file.read_bytes() == before
    assert not (tmp_path / "rest").exists()


def test_a_rest_that_is_there_already_is_not_written_over(file, tmp_path):
    before = cut(file, 0.55)
    (tmp_path / "rest").write_text("of an earlier repair")
    with pytest.raises(RecordingError, match="is there already"):
        repair(file, tmp_path / "rest")
    assert file.read_bytes() == before
    assert (tmp_path / "rest").read_text() == "of an earlier repair"


@pytest.mark.parametrize(
    ("number", "cure"),
    [
        (errno.ENOENT, "give the path of a recording"),
        (errno.EISDIR, "give the path of a recording, as FOLDER/*.mcap"),
        (errno.ENOSPC, "free some space there"),
        (errno.EACCES, "repair it as the user whose file it is"),
        (errno.EROFS, "copy it to a disk that can be written"),
        (errno.EIO, "copy it to another disk"),
    ],
)
def test_what_keeps_a_repair_from_its_file_names_a_cure_of_its_own(file, monkeypatch, number, cure):
    def refused(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("common.recording.repair.scan", refused)
    with pytest.raises(RecordingError, match=rf"{os.strerror(number)}; {re.escape(cure)}"):
        repair(file)


def test_a_small_files_progress_counts_its_kilobytes(file, monkeypatch):
    size, told = len(cut(file, 0.9)), []
    monkeypatch.setattr("farhand.commands.record.progress_bar", lambda: nullcontext(lambda *bar: told.append(bar)))
    assert CliRunner().invoke(app, ["record", "repair", str(file)]).exit_code == 0
    what, done, total = told[-1]
    assert (what, total) == ("run.mcap, kB", -(-size // 1000))
    assert 0 < done <= total


def test_one_that_cannot_be_repaired_does_not_keep_the_others_from_it(file, tmp_path):
    cut(file, 0.55)
    hopeless = tmp_path / "a.mcap"
    hopeless.write_text("no recording")
    result = CliRunner().invoke(app, ["record", "repair", str(hopeless), str(file)])
    assert result.exit_code == 1
    assert "run.mcap is repaired" in result.output
    assert (tmp_path / "run.mcap.rest").exists()


def test_a_repair_tells_how_far_it_has_read(file, tmp_path):
    size, told = len(cut(file, 0.9)), []
    done = repair(file, tmp_path / "rest", lambda read, of: told.append((read, of)))
    assert told == sorted(told)
    assert told[-1] == (size - done.cut_bytes, size)
    assert len(told) > 4
