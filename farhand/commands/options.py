"""Arguments that several commands have in common, and what the commands make of them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from common.config.loading import load_config
from common.errors import ConfigError
from common.process.log import LogFormat
from common.process.service import StopFlag
from common.text import instead_of
from farhand.commands.completion import setting_words

if TYPE_CHECKING:
    from farhand.router import RouterConfig
    from local_site.config import LocalConfig
    from local_site.console.config import ConsoleConfig
    from remote_site.config import RemoteConfig

C = TypeVar("C", "RemoteConfig", "LocalConfig", "ConsoleConfig", "RouterConfig")

ConfigFile = Annotated[
    Path | None, typer.Option("--config", help="TOML file, as 'farhand config show' prints one; else the defaults.")
]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", help="Override one key, as table.key=value; repeatable.", autocompletion=setting_words),
]
LogLines = Annotated[LogFormat, typer.Option("--log-format", help="text (level=... event=...) or json, on stderr.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as JSON, as docs/json.md describes it.")]
Emulate = Annotated[
    bool,
    typer.Option(
        "--emulate",
        help="c500c, franka: an emulated robot instead of the real one; the same as --set driver.emulate=true.",
    ),
]

LinksFile = Annotated[
    Path | None, typer.Option("--config", help="The console's TOML file: cell, operator, endpoints and certificates.")
]
CellName = Annotated[str, typer.Option("--cell", help="Name of the cell.")]
RemoteEndpoint = Annotated[str, typer.Option("--remote", help="Control endpoint of the remote site.")]
VideoEndpoint = Annotated[str, typer.Option("--video", help="Video endpoint of the remote site.")]
LocalEndpoint = Annotated[str, typer.Option("--local", help="Where the local site of this host listens.")]

TRACKER_HELP = (
    "silhouette: a bare arm before a dark wall; learned: a bare arm in an ordinary room; "
    "eye: the same by networks of Farhand's own; markers: three bright ones on a dark glove; "
    "monocular: one camera; or an installed one."
)


def known_tracker(name: str | None) -> str | None:
    """The tracker that an option names; a misuse of the option where there is none of that name."""
    if name is not None:
        from local_site.tracking.registry import tracker_names

        if name not in tracker_names():
            raise typer.BadParameter(f"there is no tracker {name!r}; {instead_of(name, tracker_names())}")
    return name


def until_signal() -> StopFlag:
    """A flag that SIGTERM and Ctrl-C set."""
    should_stop = StopFlag()
    should_stop.install()
    return should_stop


def emulation(asked: bool) -> tuple[str, ...]:
    """The setting of `--emulate`."""
    return ("driver.emulate=true",) if asked else ()


def driver_file(name: str | None) -> Path | None:
    """The remote site's file of the only arm that a driver moves, None where it moves any."""
    from remote_site.drivers.config import DRIVER_FILES

    return DRIVER_FILES.get(name or "")


def load_own(kind: type[C], path: Path | None, settings: Sequence[str] = ()) -> C:
    """The configuration; ConfigError names every mistake, or whose the file is where it is for another command."""
    try:
        return load_config(kind, path, settings)
    except ConfigError as error:
        from farhand.deployment.mix_ups import mix_up

        if path is not None and (sentence := mix_up(path, kind)):
            raise ConfigError(sentence) from error
        raise


def console_config(config: Path | None, **given: str) -> "ConsoleConfig":
    """The sites to ask, and the certificates: the console's configuration, overridden by the command line."""
    from local_site.console.config import ConsoleConfig

    settings = [f"{key if key == 'cell' else f'links.{key}'}={value}" for key, value in given.items() if value]
    return load_own(ConsoleConfig, config, settings)
