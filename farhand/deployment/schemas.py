"""JSON schemas of the configurations, by which editors complete keys and mark mistakes."""

import json
from pathlib import Path
from typing import Any

import msgspec

from farhand.deployment.kinds import KINDS, Configuration
from farhand.deployment.mix_ups import COMMANDS
from farhand.outputs import make_folder, write_result

DIALECT = "https://json-schema.org/draft/2020-12/schema"
SCHEMAS = "schemas"  # the folder beside a configuration, as its first line names it


def schema_of(kind: type[Configuration]) -> dict[str, Any]:
    """The schema of a kind of configuration: every key with its type, bounds, default and meaning."""
    return {"$schema": DIALECT, "title": f"configuration of Farhand's {KINDS[kind]}", **msgspec.json.schema(kind)}


def schema_line(kind: type[Configuration]) -> str:
    """The first line of a configuration, which names its schema to editors."""
    return f"#:schema {SCHEMAS}/{COMMANDS[kind]}.json"


def schema_files(folder: Path) -> dict[Path, bytes]:
    """FOLDER/COMMAND.json for each kind, with its content."""
    return {folder / f"{command}.json": _content(kind) for kind, command in COMMANDS.items()}


def add_schema(kind: type[Configuration], beside: Path) -> None:
    """Write the schema that a configuration's first line names, where there is none; ConfigError if that fails."""
    path = beside.parent / SCHEMAS / f"{COMMANDS[kind]}.json"
    if not path.exists():
        make_folder(SCHEMAS, path.parent)
        write_result(path, _content(kind))


def write_schemas(folder: Path, option: str) -> list[Path]:
    """Write the schemas, over those of another release; the files.

    ConfigError, which names the option, when the folder cannot be written.
    """
    make_folder(option, folder)
    files = schema_files(folder)
    for path, content in files.items():
        write_result(path, content)
    return list(files)


def _content(kind: type[Configuration]) -> bytes:
    return (json.dumps(schema_of(kind), indent=1) + "\n").encode()
