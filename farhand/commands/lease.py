"""The commands under `farhand lease`."""

from pathlib import Path

import typer

from farhand.commands.options import CellName, LinksFile, LocalEndpoint, RemoteEndpoint, console_config

lease_app = typer.Typer(
    help="Show who may operate a cell; take the lease, hand it over, release it.", no_args_is_help=True
)


@lease_app.command("show")
def show(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None) -> None:
    """Show who holds the lease of a cell, who asks for it, and what is still missing to engage.

    Example: farhand lease show --cell cell
    """
    from farhand.authority.lease import show_lease

    links = console_config(config, cell=cell, control=at)
    typer.echo(show_lease(links.cell, links.links.control, links.links))


@lease_app.command("take")
def take(cell: CellName = "", at: LocalEndpoint = "", config: LinksFile = None) -> None:
    """Ask for the lease; while another operator holds it, ask for a minute for consent.

    Example: farhand lease take
    """
    _act("take", cell, at, config)


@lease_app.command("give")
def give(cell: CellName = "", at: LocalEndpoint = "", config: LinksFile = None) -> None:
    """Consent: hand the lease to the operator who asks for it. The arm stops.

    Example: farhand lease give
    """
    _act("give", cell, at, config)


@lease_app.command("release")
def release(cell: CellName = "", at: LocalEndpoint = "", config: LinksFile = None) -> None:
    """Release the lease, so that any operator may take it. The arm stops.

    Example: farhand lease release
    """
    _act("release", cell, at, config)


def _act(action: str, cell: str, at: str, config: Path | None) -> None:
    from common.messages.requests import OperatorAction
    from farhand.authority.lease import act_on_lease

    links = console_config(config, cell=cell, local=at)
    typer.echo(act_on_lease(links.cell, links.links.local, OperatorAction(action), links.links))
