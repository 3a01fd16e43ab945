"""Topics of the wire, the folder's names and rights, and what has to go when there is too much."""

import json
from datetime import UTC, datetime
from pathlib import Path

import msgspec
import pytest

from common.errors import ConfigError
from common.link.channels import CHANNELS, PROCEDURES
from common.messages.base import PROTOCOL_VERSION
from common.recording.folder import NAME, FoundFile, file_name, found, make_private, recordings_folder, too_old
from common.recording.topics import json_topic
from common.recording.wire_topics import topic_of

FILES = [FoundFile(Path(name), 10) for name in "abcd"]


def test_every_message_has_a_topic_of_its_kind() -> None:
    for channel in CHANNELS:
        topic = topic_of(channel.key_for("cell", "side", "anna"), sent=True)
        assert topic.schema.name == f"farhand.{channel.message.__name__}.v{PROTOCOL_VERSION}"
    for procedure in PROCEDURES:
        key = procedure.key_for("cell", operator="anna")
        asked, answered = topic_of(key, sent=False), topic_of(key, sent=True)
        assert asked.schema.name == f"farhand.{procedure.request.__name__}.v{PROTOCOL_VERSION}"
        assert answered.schema.name == f"farhand.{procedure.reply.__name__}.v{PROTOCOL_VERSION}"
        assert asked.name != answered.name
    assert topic_of("farhand/cell/nothing/known", sent=True).schema.name.startswith("farhand.unknown")


def test_the_schema_of_json_describes_its_fields() -> None:
    class Inner(msgspec.Struct):
        x: float

    class Outer(msgspec.Struct):
        inner: Inner
        names: list[str]

    schema = json.loads(json_topic("/outer", Outer).schema.data)
    assert set(schema["properties"]) == {"inner", "names"}
    assert schema["$defs"]["Inner"]["properties"]["x"]["type"] == "number"


def test_the_oldest_go_until_the_rest_fits_but_never_the_one_that_grows() -> None:
    assert too_old(FILES, 40, Path("d")) == []
    assert too_old(FILES, 25, Path("d")) == [Path("a"), Path("b")]
    assert too_old(FILES, 5, Path("d")) == [Path("a"), Path("b"), Path("c")]
    assert too_old(FILES, 15, Path("a")) == [Path("b"), Path("c"), Path("d")]


def test_only_recordings_count_and_they_sort_by_time(tmp_path: Path) -> None:
    first, second = (datetime(2026, 3, day, 4, 5, 6, tzinfo=UTC) for day in (9, 10))
    names = [file_name(first, "cell-2", 1), file_name(first, "cell-2", 2), file_name(second, "a", 1)]
    for name in [*reversed(names), "notes.txt", "other.mcap"]:
        (tmp_path / name).write_bytes(b"x")
    assert all(NAME.fullmatch(name) for name in names)
    assert [file.path.name for file in found(tmp_path)] == names


def test_a_folder_into_which_others_may_look_is_refused(tmp_path: Path) -> None:
    make_private(tmp_path / "new")
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o700
    (tmp_path / "open").mkdir(mode=0o755)
    (tmp_path / "open").chmod(0o755)
    with pytest.raises(ConfigError, match="chmod 700"):
        make_private(tmp_path / "open")


def test_recordings_lie_in_the_services_state_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STATE_DIRECTORY", "/var/lib/farhand")
    assert recordings_folder("", "recordings") == Path("/var/lib/farhand/recordings")
    assert recordings_folder("/data", "recordings") == Path("/data")
