"""The commands under `farhand maintenance`."""

from typing import TYPE_CHECKING

import typer

from farhand.commands.options import CellName, LinksFile, RemoteEndpoint, console_config

if TYPE_CHECKING:
    from local_site.console.config import ConsoleConfig

maintenance_app = typer.Typer(help="Stop and reset the arm, without the right to operate it.", no_args_is_help=True)


@maintenance_app.command("stop")
def stop(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None) -> None:
    """Stop the arm and bar every engagement until it is reset; needs no lease.

    Example: farhand maintenance stop --config /etc/farhand/maintenance.toml
    """
    _ask("stop", console_config(config, cell=cell, control=at))


@maintenance_app.command("reset")
def reset(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None) -> None:
    """Clear a stop or a fault, and wake a robot that has stopped; nothing moves until the operator engages.

    Example: farhand maintenance reset --config /etc/farhand/maintenance.toml
    """
    _ask("reset", console_config(config, cell=cell, control=at))


def _ask(action: str, links: "ConsoleConfig") -> None:
    from common.messages.requests import EngagementAction
    from farhand.authority.engage import request_maintenance

    typer.echo(request_maintenance(links.cell, links.links.control, EngagementAction(action), links.name, links.links))
