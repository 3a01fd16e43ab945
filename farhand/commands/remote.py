"""`farhand remote`."""

from typing import Annotated

import typer

from common.config import load_config
from common.process.log import LogFormat
from farhand.commands.options import ConfigFile, LogLines, Settings, until_signal


def remote(
    config: ConfigFile = None,
    settings: Settings = None,
    driver: Annotated[str | None, typer.Option(help="The robot's driver: the same as --set driver.name=NAME.")] = None,
    emulate: Annotated[bool, typer.Option("--emulate", help="c500c: against an emulated controller.")] = False,
    cell: Annotated[str, typer.Option(help="Name of this cell: the same as --set cell=NAME.")] = "",
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Start the robot's side: follow the hand inside the limits, and stream the cell.

    Example: farhand remote --config remote.toml --driver kinematic
    """
    from remote_site.config import RemoteConfig
    from remote_site.runtime.app import run_remote

    chosen = ([f"driver.name={driver}"] if driver else []) + (["driver.emulate=true"] if emulate else [])
    chosen += [f"cell={cell}"] if cell else []
    run_remote(load_config(RemoteConfig, config, [*(settings or ()), *chosen]), until_signal(), log_format)
