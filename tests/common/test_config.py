"""Configuration: all mistakes of a file together, each with its line and cure."""

import re
import tracemalloc
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import pytest

from common.config.loading import beside, load_config
from common.errors import ConfigError


class Inner(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    speed: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.5
    name: str = "a"


class Way(StrEnum):
    THERE = "there"
    BACK = "back"


class Light(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    way: Way = Way.THERE
    level: Annotated[Annotated[float, msgspec.Meta(gt=0)] | Literal["auto"] | None, msgspec.Meta(description="x")] = (
        None
    )
    steps: int | Literal["auto", "off"] | None = None
    code: Annotated[
        Annotated[str, msgspec.Meta(pattern="^[A-Z]{4}$")] | None, msgspec.Meta(description='code of four: "MJPG"')
    ] = None


class Outer(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    inner: Inner = Inner()
    count: int = 3
    lights: Annotated[Light, msgspec.Meta(description="all lights")] = Light()
    light: Annotated[dict[str, Light], msgspec.Meta(description="one light, by its name")] = msgspec.field(
        default_factory=dict
    )


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


def test_described_tables_and_tables_by_name_are_told_key_by_key(tmp_path: Path) -> None:
    path = write(
        tmp_path, '[lights]\nlevle = 1\nlevel = "atuo"\n[light.left]\nsteps = 1.5\n[light.right]\ncode = "x"\n'
    )
    with pytest.raises(ConfigError) as caught:
        load_config(Outer, path)
    assert str(caught.value).splitlines() == [
        f"{path}:2: lights.levle: is not a key here; did you mean level?",
        f"{path}:3: lights.level: 'atuo' is not allowed: did you mean auto?",
        f"{path}:5: light.left.steps: 1.5 is not allowed: choose one of auto, off or give a whole number",
        f"{path}:7: light.right.code: 'x' is not allowed: give a code of four: \"MJPG\"",
    ]


def test_tables_by_name_are_read(tmp_path: Path) -> None:
    path = write(tmp_path, '[light.left]\nlevel = "auto"\n[light.right]\nlevel = 2\n')
    assert load_config(Outer, path).light == {"left": Light(level="auto"), "right": Light(level=2.0)}


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("light.left=3", "must be a table: [light.left]"),
        ("lights=3", "must be a table: [lights]"),
        ("lights.level=-1", "-1 is not allowed: give a number > 0.0 (x)"),
        ("lights.way=foo", "'foo' is not allowed: choose one of there, back"),
        ("lights.way=bakc", "'bakc' is not allowed: did you mean back?"),
        ("lights.way=3", "3 is not allowed: choose one of there, back"),
        ("lights.level=[]", "[] is not allowed: choose auto or give a number"),
        ("lights.code=3", '3 is not allowed: give words in quotes, not a whole number (code of four: "MJPG")'),
    ],
)
def test_what_is_allowed_is_told(setting: str, told: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_config(Outer, None, [setting])
    assert str(caught.value) == f"--set {setting.partition('=')[0]}: {told}"


@pytest.mark.parametrize("setting", ["inner.speed", "=1", "count.x=1", "inner..speed=1"])
def test_a_setting_that_cannot_be_applied_is_refused(setting: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="--set"):
        load_config(Outer, write(tmp_path, "count = 1\n"), [setting])


class Named(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    name: str = "a"
    low: float = 0.0
    high: float = 1.0

    def __post_init__(self) -> None:
        if self.name == "B":
            raise ConfigError("name 'B': use small letters")
        if self.low > self.high:
            raise ValueError("low and high are the wrong way round; exchange them")


def test_what_a_table_says_of_one_of_its_keys_has_the_line_of_that_key(tmp_path: Path) -> None:
    path = write(tmp_path, 'low = 0.5\nname = "B"\n')
    with pytest.raises(ConfigError) as caught:
        load_config(Named, path)
    assert str(caught.value) == f"{path}:2: name: 'B': use small letters"
    with pytest.raises(ConfigError) as caught:
        load_config(Named, write(tmp_path, "low = 2.0\n"))
    assert str(caught.value) == f"{path}:1: low and high are the wrong way round; exchange them"


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("name=B", "--set name: 'B': use small letters"),
        ("low=2", "--set low and high are the wrong way round; exchange them"),
    ],
)
def test_what_a_setting_makes_wrong_is_told_as_a_settings(setting: str, told: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_config(Named, None, [setting])
    assert str(caught.value) == told


def test_a_wrong_setting_is_told_as_such() -> None:
    with pytest.raises(ConfigError, match=r"--set inner\.speed: -1"):
        load_config(Outer, None, ["inner.speed=-1"])


def test_bad_toml_and_missing_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="not valid TOML"):
        load_config(Outer, write(tmp_path, "count = ="))
    with pytest.raises(ConfigError, match="No such file"):
        load_config(Outer, tmp_path / "absent.toml")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("count = 1\ncount = 2\n", r"site\.toml:2: not valid TOML: .*this key stands twice"),
        ("[inner]\nspeed = 1.0\n[inner]\n", r"site\.toml:3: not valid TOML: .*this table stands twice"),
        ("name = bare\n", r'site\.toml:1: not valid TOML: .*in quotes, as "word"'),
    ],
)
def test_what_people_do_wrong_in_toml_is_told_with_its_line_and_its_cure(
    content: str, told: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=told):
        load_config(Outer, write(tmp_path, content))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a = " + "[" * 100_000, "more than 32 tables or lists within one another"),
        *((".".join([key] * 50) + " = 1", "more than 32 tables or lists within one another") for key in ("a", "'a'")),
        ("a = {" + "b = {" * 40 + "}" * 41, "more than 32 tables or lists within one another"),
        ("a = " + "9" * 5_000, "not valid TOML: .*integer"),
    ],
)
def test_toml_that_is_too_deep_or_too_long_for_the_parser_is_refused(text: str, told: str, tmp_path: Path) -> None:
    path = write(tmp_path, text)
    with pytest.raises(ConfigError, match=told):
        load_config(Outer, path)


@pytest.mark.parametrize("key", ["a.", '"a" . '])
def test_a_key_of_thousands_of_parts_takes_no_memory(key: str, tmp_path: Path) -> None:
    path = write(tmp_path, key * 3_000 + "a = 1")
    tracemalloc.start()
    try:
        with pytest.raises(ConfigError, match="more than 32 tables"):
            load_config(Outer, path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 5e6


@pytest.mark.parametrize("value", ["[" * 100_000, "9" * 5_000])
def test_a_setting_that_is_too_deep_or_too_long_for_the_parser_is_refused(value: str) -> None:
    with pytest.raises(ConfigError, match="count"):
        load_config(Outer, None, [f"count={value}"])


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


@pytest.mark.parametrize(
    ("text", "line", "key"),
    [
        ("inner = { speed = 0.5, name = 3 }\n", 1, "inner.name"),
        ("count = 1\ninner.name = 3\n", 2, "inner.name"),
        ("count = 1\n\"inner\" . 'name' = 3\n", 2, "inner.name"),
        ('[light]\n[light.left]\nlevel = [\n  [1],\n  [2]\n]\ncode = "x"\n', 7, "light.left.code"),
        ('[light.left]\ncode = "ABCD" # code = 1\nlevel = "x"\n', 3, "light.left.level"),
    ],
)
def test_a_key_has_its_line_however_it_is_written(text: str, line: int, key: str, tmp_path: Path) -> None:
    path = write(tmp_path, text)
    with pytest.raises(ConfigError) as caught:
        load_config(Outer, path)
    assert any(told.startswith(f"{path}:{line}: {key}: ") for told in str(caught.value).splitlines()), caught.value


class Whole(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    inner: Inner = Inner()
    named: Named = Named()

    def __post_init__(self) -> None:
        if self.inner.speed > self.named.low:
            raise ValueError("the speed of the inner one is too high: lower inner.speed, or raise named.low")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("[named]\nname = 'a'\n[inner]\nspeed = 0.5\n", 4),
        ("[inner]\n[named]\nlow = 0.1\n", 3),
        ("[named]\n[inner]\n", 2),
        ("named.low = 0.1\n[inner]\nname = 'b'\n", 1),
    ],
)
def test_what_is_wrong_between_tables_has_the_line_of_the_first_key_that_is_named_and_given(
    text: str, line: int, tmp_path: Path
) -> None:
    path = write(tmp_path, text)
    with pytest.raises(ConfigError, match=rf"^{re.escape(str(path))}:{line}: the speed of the inner"):
        load_config(Whole, path)


def test_what_a_setting_makes_wrong_between_tables_is_told_as_a_settings(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"^--set the speed of the inner one"):
        load_config(Whole, write(tmp_path, "[named]\nlow = 0.1\n"), ["inner.speed=0.3"])


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ("1979-05-27", "1979-05-27 is not allowed: give a whole number, not a date"),
        ("1979-05-27T07:32:00", "1979-05-27T07:32:00 is not allowed: give a whole number, not a date with a time"),
        ("07:32:00", "07:32:00 is not allowed: give a whole number, not a time of day"),
        ("true", "true is not allowed: give a whole number, not true or false"),
        (
            "[{ a = 07:32:00, b = false }]",
            "[{a = 07:32:00, b = false}] is not allowed: give a whole number, not a list",
        ),
    ],
)
def test_a_value_is_told_as_it_is_written(value: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        load_config(Outer, write(tmp_path, f"count = {value}\n"))
    assert told in str(caught.value)


class Row(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    at: tuple[float, float]
    speed: Annotated[float, msgspec.Meta(gt=0)] = 1.0


class Rows(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    rows: Annotated[tuple[Row, ...], msgspec.Meta(max_length=2)] = msgspec.field(default=(), name="row")


def test_a_list_of_tables_is_told_table_by_table(tmp_path: Path) -> None:
    path = write(tmp_path, "[[row]]\nat = [1, 2]\nspeed = -1\n[[row]]\nsped = 2\n")
    with pytest.raises(ConfigError) as caught:
        load_config(Rows, path)
    assert str(caught.value).splitlines() == [
        f"{path}:3: row.1.speed: -1 is not allowed: give a number > 0.0",
        f"{path}:5: row.2.sped: is not a key here; did you mean speed?",
        f"{path}:4: row.2.at: is missing; give it a value",
    ]


def test_a_list_of_tables_is_read_and_its_length_is_checked(tmp_path: Path) -> None:
    text = "[[row]]\nat = [1, 2]\n[[row]]\nat = [3, 4]\nspeed = 2\n"
    assert load_config(Rows, write(tmp_path, text)).rows == (Row(at=(1, 2)), Row(at=(3, 4), speed=2))
    with pytest.raises(ConfigError, match="give a list of at most 2"):
        load_config(Rows, write(tmp_path, f"{text}[[row]]\nat = [5, 6]\n"))


class Model(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    file: Annotated[str, msgspec.Meta(extra=beside(unless=lambda value: value == "built-in"))] = "built-in"
    name: str = ""


class WithModel(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    model: Model = Model()


def test_a_marked_path_is_seen_from_the_configurations_folder_and_from_nowhere_else(tmp_path, monkeypatch):
    work = tmp_path / "work"
    work.mkdir()
    (work / "arm.urdf").touch()
    monkeypatch.chdir(work)
    path = write(tmp_path, '[model]\nfile = "arm.urdf"\nname = "arm.urdf"')
    for seen in (path, Path("..") / path.name):
        found = load_config(WithModel, seen).model
        assert Path(found.file).is_absolute()
        assert Path(found.file).resolve() == (tmp_path / "arm.urdf").resolve()
        assert found.name == "arm.urdf"
    assert load_config(WithModel, path, ["model.file=arm.urdf"]).model.file == "arm.urdf"
    assert load_config(WithModel, None).model.file == "built-in"
    for kept in ("built-in", "/opt/arm.urdf"):
        assert load_config(WithModel, write(tmp_path, f'[model]\nfile = "{kept}"')).model.file == kept
