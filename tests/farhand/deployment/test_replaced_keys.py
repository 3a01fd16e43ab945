"""Every key of an earlier release is either known or refused with the name of what replaced it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from common.config.loading import load_config
from common.config.replaced_keys import GONE_KEYS, REPLACED_KEYS
from common.errors import ConfigError, RecordingError
from farhand.commands.options import load_own
from farhand.deployment.kinds import KINDS, Configuration
from remote_site.config import RemoteConfig
from remote_site.recording.kept_config import decode_config, encode_config

ROOT = Path(__file__).parents[3]
RELEASED = [line.split() for line in (ROOT / "tests/golden/release-0.1.0/keys.txt").read_text().splitlines()]
NAMED = {name.split()[0]: kind for kind, name in KINDS.items()}
# Gone before 0.1.0 was made, but in notes of it.
UNRELEASED: dict[str, type[Configuration]] = {"engagement.automatic": RemoteConfig}
OWNERS = UNRELEASED | {key: NAMED[kind] for kind, key in RELEASED if key in REPLACED_KEYS}


def structs_in(expected: Any) -> Iterator[type[msgspec.Struct]]:
    if isinstance(expected, type) and issubclass(expected, msgspec.Struct):
        yield expected
    for part in get_args(expected):
        yield from structs_in(part)


def knows(struct: type[msgspec.Struct], *path: str) -> bool:
    types = {field.encode_name: field.type for field in msgspec.structs.fields(struct)}
    key, *rest = path
    return key in types and (not rest or any(knows(inner, *rest) for inner in structs_in(types[key])))


def is_known(kind: type[Configuration], key: str) -> bool:
    return knows(kind, *key.split("."))


def file_with(tmp_path: Path, key: str, value: str) -> Path:
    *table, leaf = key.split(".")
    path = tmp_path / "site.toml"
    path.write_text(f"[{'.'.join(table)}]\n{leaf} = {value}\n" if table else f"\n{leaf} = {value}\n")
    return path


@pytest.mark.parametrize(("kind", "key"), RELEASED)
def test_every_released_key_is_known_or_replaced(kind: str, key: str) -> None:
    assert is_known(NAMED[kind], key) != (key in REPLACED_KEYS or key in GONE_KEYS)


def test_the_table_has_no_key_that_never_was() -> None:
    assert OWNERS.keys() == REPLACED_KEYS.keys()


@pytest.mark.parametrize("key", REPLACED_KEYS)
def test_a_replaced_key_is_unknown_and_its_replacement_exists(key: str) -> None:
    assert not is_known(OWNERS[key], key)
    assert is_known(OWNERS[key], REPLACED_KEYS[key].key)


@pytest.mark.parametrize("key", REPLACED_KEYS)
def test_a_replaced_key_in_a_file_is_refused_at_its_line(key: str, tmp_path: Path) -> None:
    path, replacement = file_with(tmp_path, key, "12"), REPLACED_KEYS[key]
    with pytest.raises(ConfigError) as refused:
        load_own(OWNERS[key], path)  # type: ignore[type-var]  # whichever it is
    assert str(refused.value) == f"{path}:2: {key}: is replaced by {replacement.key}: {replacement.how}"


@pytest.mark.parametrize("key", REPLACED_KEYS)
def test_a_replaced_key_in_a_setting_is_refused(key: str) -> None:
    replacement = REPLACED_KEYS[key]
    with pytest.raises(ConfigError) as refused:
        load_config(OWNERS[key], None, [f"{key}=12"])
    assert str(refused.value) == f"--set {key}: is replaced by {replacement.key}: {replacement.how}"


@pytest.mark.parametrize("key", [key for key in REPLACED_KEYS if OWNERS[key] is RemoteConfig])
def test_a_replaced_key_in_a_recording_is_refused(key: str) -> None:
    recorded = msgspec.json.decode(encode_config(RemoteConfig()))
    *tables, leaf = key.split(".")
    table = recorded
    for name in tables:
        table = table[name]
    table[leaf] = 12
    with pytest.raises(RecordingError) as refused:
        decode_config(msgspec.json.encode(recorded))
    assert f"{key}: is replaced by {REPLACED_KEYS[key].key}: " in str(refused.value)
    assert str(refused.value).endswith("; use the release that recorded it")


@pytest.mark.parametrize("key", REPLACED_KEYS)
def test_the_upgrade_note_names_both_keys(key: str) -> None:
    rows = [row for row in (ROOT / "docs/upgrading.md").read_text().splitlines() if row.startswith(f"| `{key}`")]
    assert [f"`{REPLACED_KEYS[key].key}`" in row for row in rows] == [True]


@pytest.mark.parametrize("key", GONE_KEYS)
def test_a_key_that_is_gone_is_refused_with_the_cure_but_in_recordings(key: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as refused:
        load_own(RemoteConfig, file_with(tmp_path, key, "false"))
    assert str(refused.value).endswith(f"{key}: {GONE_KEYS[key]}")
    recorded = msgspec.json.decode(encode_config(RemoteConfig()))
    table, leaf = key.split(".")
    recorded[table][leaf] = False
    assert decode_config(msgspec.json.encode(recorded)) == RemoteConfig()
    assert any(row.startswith(f"| `{key}` |") for row in (ROOT / "docs/upgrading.md").read_text().splitlines())
