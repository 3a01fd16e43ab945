"""JSON schemas of the configurations, by which editors complete keys and mark mistakes."""

import json
from pathlib import Path
from typing import Any

import msgspec

from farhand.deployment.kinds import KINDS, Configuration
from farhand.deployment.mix_ups import COMMANDS
from farhand.outputs import make_folder, write_result

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema_of(kind: type[Configuration]) -> dict[str, Any]:
    """The schema of a kind of configuration: every key with its type, bounds, default and meaning."""
    return {"$schema": DIALECT, "title": f"configuration of Farhand's {KINDS[kind]}", **msgspec.json.schema(kind)}


def schema_files(folder: Path) -> dict[Path, bytes]:
    """FOLDER/COMMAND.json for each kind, with its content."""
    return {
        folder / f"{command}.json": (json.dumps(schema_of(kind), indent=1) + "\n").encode()
        for kind, command in COMMANDS.items()
    }


def write_schemas(folder: Path, option: str) -> list[Path]:
    """Write the schemas, over those of another release; the files.

    ConfigError, which names the option, when the folder cannot be written.
    """
    make_folder(option, folder)
    files = schema_files(folder)
    for path, content in files.items():
        write_result(path, content)
    return list(files)
