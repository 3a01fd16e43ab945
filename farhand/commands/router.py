"""`farhand router`."""

from typing import Annotated

import typer

from common.config import load_config
from common.process.log import LogFormat
from farhand.commands.options import ConfigFile, LogLines, Settings, until_signal


def router(
    config: ConfigFile = None,
    settings: Settings = None,
    zenohd: Annotated[bool, typer.Option("--zenohd", help="Only print the same as zenohd's configuration.")] = False,
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Start the meeting point for sites that cannot reach each other, as behind NAT.

    Example: farhand router --config router.toml
    """
    from farhand.router import RouterConfig, run_router, zenohd_configuration

    loaded = load_config(RouterConfig, config, settings or ())
    if zenohd:
        typer.echo(zenohd_configuration(loaded))
    else:
        run_router(loaded, until_signal(), log_format)
