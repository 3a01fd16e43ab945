"""`farhand status`: one screen of what a running cell does."""

from typing import Annotated

import typer

from farhand.commands.options import (
    AsJson,
    CellName,
    LinksFile,
    RemoteEndpoint,
    VideoEndpoint,
    console_config,
    until_signal,
)


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
