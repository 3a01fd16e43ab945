"""A configuration given to the command of another one: whose it is, and the command that it is for."""

from pathlib import Path

from common.config.loading import read_tables
from common.errors import ConfigError
from farhand.deployment.kinds import KINDS, Configuration, likeliest
from farhand.router import RouterConfig
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from remote_site.config import RemoteConfig

COMMANDS: dict[type[Configuration], str] = {
    RemoteConfig: "remote",
    LocalConfig: "local",
    ConsoleConfig: "console",
    RouterConfig: "router",
}


def mix_up(path: Path, *wanted: type[Configuration]) -> str:
    """Say that a file, by its tables and keys, is another configuration than those wanted; else nothing."""
    try:
        kinds = likeliest(read_tables(path), tuple(KINDS))
    except ConfigError:
        return ""
    if set(kinds) & set(wanted):
        return ""
    own, names = " or ".join(KINDS[kind] for kind in kinds), " or ".join(KINDS[kind] for kind in wanted)
    shown = " or ".join(f"'farhand config show {COMMANDS[kind]}'" for kind in wanted)
    return (
        f"{path} is a file of the {own}; this command takes one of the {names}\n"
        f"for this file: farhand {COMMANDS[kinds[0]]} --config {path}\n"
        f"for this command: a file as {shown} prints it"
    )
