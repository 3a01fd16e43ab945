"""`farhand engage`."""

from typing import Annotated

import typer

from farhand.commands.options import CellName, LinksFile, RemoteEndpoint, console_config


def engage(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    operator: Annotated[str, typer.Option(help="The operator's name, where it is not this host's.")] = "",
    config: LinksFile = None,
) -> None:
    """Let the arm follow the hand again, after a stop or a restart of the local site.

    Example: farhand engage --cell cell
    """
    from farhand.authority.engage import request_engage

    links = console_config(config, cell=cell, control=at)
    typer.echo(request_engage(links.cell, links.links.control, operator or links.name, links.links))
