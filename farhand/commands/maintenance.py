"""`farhand maintenance`: stop and reset the arm without holding the lease."""

from pathlib import Path

import typer

from farhand.commands.options import CellName, LinksFile, RemoteEndpoint, console_config

maintenance_app = typer.Typer(help="Stop and reset the arm, without holding the lease.", no_args_is_help=True)


@maintenance_app.command("stop")
def stop(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None) -> None:
    """Stop the arm and refuse every engagement until it is reset; needs no lease.

    Example: farhand maintenance stop --config /etc/farhand/maintenance.toml
    """
    _request("stop", cell, at, config)


@maintenance_app.command("reset")
def reset(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None) -> None:
    """Clear a stop or a fault, and wake a robot that has stopped; nothing moves until the operator engages.

    Example: farhand maintenance reset --config /etc/farhand/maintenance.toml
    """
    _request("reset", cell, at, config)


def _request(action: str, cell: str, at: str, config: Path | None) -> None:
    from common.messages.requests import EngagementAction
    from farhand.authority.engage import request_maintenance

    links = console_config(config, cell=cell, control=at)
    typer.echo(request_maintenance(links.cell, links.links.control, EngagementAction(action), links.name, links.links))
