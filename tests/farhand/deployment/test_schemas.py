"""The schemas of configurations know what the reader knows: every shipped file, every key, no other one."""

import json
from pathlib import Path
from typing import Any

import msgspec
import pytest
from typer.testing import CliRunner

from common.config.loading import read_tables
from farhand.cli import app
from farhand.deployment.kinds import KINDS, likeliest
from farhand.deployment.schemas import schema_of
from remote_site.config import RemoteConfig
from tests.farhand.deployment.test_shipped import KINDS as KIND_OF

ROOT = Path(__file__).parents[3]
SHIPPED = [
    path
    for package in ("common", "farhand", "local_site", "remote_site")
    for path in sorted((ROOT / package).rglob("*.toml"))
    if path.name != "pyproject.toml"
]


def resolved(part: dict[str, Any], whole: dict[str, Any]) -> dict[str, Any]:
    """A part of a schema in the place of what only refers to it."""
    name = part.get("$ref", "").removeprefix("#/$defs/")
    return whole["$defs"][name] if name else part


def unknown_keys(value: Any, part: dict[str, Any], whole: dict[str, Any]) -> list[str]:
    """The keys of a file that its schema does not have."""
    part = resolved(part, whole)
    if isinstance(value, list):
        return [key for own in value for key in unknown_keys(own, part.get("items") or {}, whole)]
    if not isinstance(value, dict) or "properties" not in part:
        return []
    known = part["properties"]
    missing = [key for key in value if key not in known]
    within = (unknown_keys(own, known[name], whole) for name, own in value.items() if name in known)
    return missing + [key for keys in within for key in keys]


def test_the_models_have_configurations_too() -> None:
    assert {path.name for path in SHIPPED} >= {"remote.toml", "fr3.toml", "humanoid.toml"}


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_a_shipped_file_names_a_schema_that_has_its_keys_and_says_who_writes_it(file: Path, tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["config", "schema", "--out", str(tmp_path / "schemas")]).exit_code == 0
    first, second, *_ = file.read_text().splitlines()
    assert "'farhand config schema' writes it" in second
    schema = json.loads((tmp_path / first.removeprefix("#:schema ")).read_text())
    (kind,) = likeliest(read_tables(file), tuple(KINDS))
    assert kind is KIND_OF.get(file.stem, RemoteConfig)
    assert schema == json.loads(json.dumps(schema_of(kind)))
    assert unknown_keys(read_tables(file), schema, schema) == []
    assert unknown_keys({"no_such": 1}, schema, schema) == ["no_such"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_schema_has_every_key_of_every_table_and_allows_no_other(kind: type[msgspec.Struct]) -> None:
    schema = schema_of(kind)  # type: ignore[arg-type]
    tables = [resolved(schema, schema), *schema["$defs"].values()]
    assert all(table["additionalProperties"] is False for table in tables if "properties" in table)
    assert set(tables[0]["properties"]) == {field.encode_name for field in msgspec.structs.fields(kind)}
