"""Configuration: all mistakes of a file together, each with its line and cure."""

from pathlib import Path
from typing import Annotated

import msgspec
import pytest

from common.config import load_config
from common.errors import ConfigError


class Inner(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    speed: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.5
    name: str = "a"


class Outer(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    inner: Inner = Inner()
    count: int = 3


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "site.toml"
    path.write_text(text)
    return path


def test_no_file_gives_the_defaults() -> None:
    assert load_config(Outer, None) == Outer()


def test_values_are_read_and_settings_win(tmp_path: Path) -> None:
    path = write(tmp_path, "count = 5\n[inner]\nspeed = 0.25\n")
    config = load_config(Outer, path, ["inner.speed=0.75", "inner.name=left"])
    assert config == Outer(count=5, inner=Inner(speed=0.75, name="left"))


def test_every_mistake_is_told_at_once_with_its_line(tmp_path: Path) -> None:
    path = write(tmp_path, 'cuont = 5\ncount = "x"\n\n[inner]\nspeed = 2.0\nspeeed = 1.0\n')
    with pytest.raises(ConfigError) as caught:
        load_config(Outer, path)
    lines = str(caught.value).splitlines()
    assert len(lines) == 4
    assert f"{path}:1: cuont" in lines[0]
    assert "did you mean count?" in lines[0]
    assert any(f"{path}:2: count" in line for line in lines)
    assert any(f"{path}:5: inner.speed" in line and "<= 1" in line for line in lines)
    assert any(f"{path}:6: inner.speeed" in line and "did you mean speed?" in line for line in lines)


@pytest.mark.parametrize("setting", ["inner.speed", "=1", "count.x=1", "inner..speed=1"])
def test_a_setting_that_cannot_be_applied_is_refused(setting: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="--set"):
        load_config(Outer, write(tmp_path, "count = 1\n"), [setting])


def test_a_wrong_setting_is_told_as_such() -> None:
    with pytest.raises(ConfigError, match=r"--set inner\.speed: -1"):
        load_config(Outer, None, ["inner.speed=-1"])


def test_bad_toml_and_missing_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="not valid TOML"):
        load_config(Outer, write(tmp_path, "count = ="))
    with pytest.raises(ConfigError, match="No such file"):
        load_config(Outer, tmp_path / "absent.toml")


def test_a_value_in_place_of_a_table_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"must be a table: \[inner\]"):
        load_config(Outer, write(tmp_path, "inner = 3\n"))


@pytest.mark.parametrize(
    ("content", "cure"),
    [
        (b"count = 5\n# f\xfcr\n", r"site\.toml:2: not UTF-8 text: .*; save the file as UTF-8"),
        (b"\xef\xbb\xbfcount = 5\n", r"site\.toml:1: .* byte order mark; save the file as UTF-8 without one"),
        (b"#" * 1_000_001, "larger than 1000000 bytes; give a TOML file"),
    ],
)
def test_a_file_in_another_encoding_or_of_another_kind_is_refused_with_its_cure(
    content: bytes, cure: str, tmp_path: Path
) -> None:
    path = tmp_path / "site.toml"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=cure):
        load_config(Outer, path)


def test_a_file_with_the_line_ends_of_windows_is_read(tmp_path: Path) -> None:
    path = tmp_path / "site.toml"
    path.write_bytes(b"count = 5\r\n[inner]\r\nspeed = 0.25\r\n")
    assert load_config(Outer, path) == Outer(count=5, inner=Inner(speed=0.25))
