"""`farhand console`."""

import typer

from common.config import load_config
from common.process.log import LogFormat
from farhand.commands.options import ConfigFile, LogLines, Settings, until_signal


def console(config: ConfigFile = None, settings: Settings = None, log_format: LogLines = LogFormat.TEXT) -> None:
    """Serve the operator's page: the cell's views, what the arm does and why, and its brakes.

    Example: farhand console --config console.toml
    """
    from local_site.console.app import run_console
    from local_site.console.config import ConsoleConfig

    run_console(load_config(ConsoleConfig, config, settings or ()), until_signal(), typer.echo, log_format)
