"""Whose configuration a file or a setting is, by the tables and keys in it; pure."""

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from farhand.router import RouterConfig
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from remote_site.config import RemoteConfig

Configuration = RemoteConfig | LocalConfig | ConsoleConfig | RouterConfig
KINDS: dict[type[Configuration], str] = {
    RemoteConfig: "remote site",
    LocalConfig: "local site",
    ConsoleConfig: "console",
    RouterConfig: "router",
}


def likeliest(table: Mapping[str, Any], kinds: Sequence[type[Configuration]]) -> list[type[Configuration]]:
    """The kinds of configuration that know most of the keys, all of them where none knows any."""
    known = {kind: known_keys(table, kind) for kind in kinds}
    return [kind for kind in kinds if known[kind] == max(known.values())]


def known_keys(table: Mapping[str, Any], kind: type[Any]) -> int:
    """Count the keys, those of nested tables included, that are keys of this configuration."""
    types = {field.name: field.type for field in msgspec.structs.fields(kind)}
    nested = ((value, types[name]) for name, value in table.items() if name in types and isinstance(value, dict))
    return len(table.keys() & types.keys()) + sum(
        known_keys(value, t) for value, t in nested if hasattr(t, "__struct_fields__")
    )
