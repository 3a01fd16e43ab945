"""The command under `farhand driver`."""

from typing import Annotated

import typer

from common.config import load_config
from farhand.commands.options import ConfigFile, Settings
from farhand.exit_codes import FAILED

driver_app = typer.Typer(help="Check robot drivers.", no_args_is_help=True)


@driver_app.command("test")
def run_suite(
    name: Annotated[str, typer.Argument(help="The driver's name, as in driver.name.")],
    config: ConfigFile = None,
    settings: Settings = None,
) -> None:
    """Check a driver against everything that Farhand expects of one; it MOVES every joint, the first by 40 degrees.

    Example: farhand driver test kinematic
    """
    from remote_site.config import RemoteConfig
    from remote_site.runtime.conformance import test_driver

    loaded = load_config(RemoteConfig, config, [*(settings or ()), f"driver.name={name}"])
    if not test_driver(loaded, typer.echo):
        raise typer.Exit(FAILED)
