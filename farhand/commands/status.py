"""`farhand status`: one screen of what a running cell does."""

from typing import Annotated

import typer

from farhand.commands.options import CellName, LinksFile, RemoteEndpoint, VideoEndpoint, console_config, until_signal


def status(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    video: VideoEndpoint = "",
    config: LinksFile = None,
    once: Annotated[bool, typer.Option("--once", help="Print it once, after three seconds of counting.")] = False,
    no_pictures: Annotated[
        bool, typer.Option("--no-pictures", help="Count no pictures: for that they are sent here, too.")
    ] = False,
) -> None:
    """Show what a cell does, live until Ctrl-C: state, lease, rates, ages, control, recorder, gripper, versions.

    It needs no lease, and changes nothing. Where the output is no terminal it is printed once.

    Example: farhand status --once
    """
    from rich.console import Console

    from farhand.status.run import show_status

    links = console_config(config, cell=cell, control=at, video=video)
    show_status(links, until_signal(), Console(), once=once, pictures=not no_pictures)
