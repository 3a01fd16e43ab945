"""The commands under `farhand config`."""

from pathlib import Path
from typing import Annotated

import typer

config_app = typer.Typer(help="Print or write the configurations that Farhand ships.", no_args_is_help=True)


@config_app.command("show")
def show(
    name: Annotated[str, typer.Argument(help="remote, local, local-cameras, console or router.")],
) -> None:
    """Print a configuration with every key explained; redirect it to a file to begin one of your own.

    Example: farhand config show remote > remote.toml
    """
    from farhand.deployment.shipped import read_configuration

    typer.echo(read_configuration(name), nl=False)


@config_app.command("init")
def init(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write to; created if missing.")],
) -> None:
    """Write every configuration and the systemd units to a folder; a file that exists is kept.

    Example: farhand config init my-cell
    """
    from farhand.deployment.shipped import write_all

    typer.echo("\n".join(write_all(folder)))
