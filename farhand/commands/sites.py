"""`farhand remote`, `local`, `console`, `router`: a site's process, until SIGTERM or Ctrl-C; `status`: what they do."""

from pathlib import Path
from typing import Annotated

import typer

from common.process.log import LogFormat
from farhand.commands.completion import driver_names
from farhand.commands.options import (
    AsJson,
    CellName,
    ConfigFile,
    Emulate,
    LinksFile,
    LogLines,
    RemoteEndpoint,
    Settings,
    VideoEndpoint,
    console_config,
    driver_file,
    emulation,
    load_own,
    until_signal,
)


def remote(
    config: ConfigFile = None,
    settings: Settings = None,
    driver: Annotated[
        str | None,
        typer.Option(
            help="The robot's driver: as --set driver.name=NAME, and franka without --config brings its arm.",
            autocompletion=driver_names,
        ),
    ] = None,
    emulate: Emulate = False,
    cell: Annotated[str, typer.Option(help="Name of this cell: the same as --set cell=NAME.")] = "",
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Start the robot's side: follow the hand inside the limits, and stream the cell.

    Example: farhand remote --config remote.toml --driver kinematic
    """
    from remote_site.config import RemoteConfig
    from remote_site.runtime.app import run_remote

    chosen = [*([f"driver.name={driver}"] if driver else []), *emulation(emulate)]
    chosen += [f"cell={cell}"] if cell else []
    file = config or driver_file(driver)
    run_remote(load_own(RemoteConfig, file, [*(settings or ()), *chosen]), until_signal(), log_format)


def local(
    config: ConfigFile = None,
    settings: Settings = None,
    save_views: Annotated[
        Path | None, typer.Option(help="Folder for the last annotated views, as PNG; earlier ones are replaced.")
    ] = None,
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Start the operator's side: track the arm and publish it.

    Example: farhand local --config local.toml
    """
    from farhand.outputs import check_folder
    from local_site.config import LocalConfig
    from local_site.runtime.app import run_local

    check_folder("--save-views", save_views)
    run_local(load_own(LocalConfig, config, settings or ()), until_signal(), save_views, log_format)


def console(config: ConfigFile = None, settings: Settings = None, log_format: LogLines = LogFormat.TEXT) -> None:
    """Serve the operator's page: the cell's views, what the arm does and why, and its brakes.

    Example: farhand console --config console.toml
    """
    from local_site.console.app import run_console
    from local_site.console.config import ConsoleConfig

    run_console(load_own(ConsoleConfig, config, settings or ()), until_signal(), typer.echo, log_format)


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

    loaded = load_own(RouterConfig, config, settings or ())
    if zenohd:
        typer.echo(zenohd_configuration(loaded))
    else:
        run_router(loaded, until_signal(), log_format)


def status(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    video: VideoEndpoint = "",
    config: LinksFile = None,
    once: Annotated[bool, typer.Option("--once", help="Print it once, after three seconds of counting.")] = False,
    no_pictures: Annotated[
        bool, typer.Option("--no-pictures", help="Count no pictures: for that they are sent here, too.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Show what a cell does, live until Ctrl-C: state, lease, rates, ages, control, recorder, gripper, versions.

    It needs no lease, and changes nothing. Where the output is no terminal, or as JSON, it is printed once.

    Example: farhand status --once
    """
    from rich.console import Console

    from farhand.status.watch import print_status, show_status

    links = console_config(config, cell=cell, control=at, video=video)
    if as_json:
        print_status(links, until_signal(), pictures=not no_pictures)
    else:
        show_status(links, until_signal(), Console(), once=once, pictures=not no_pictures)
