"""The commands under `farhand certificates`."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

DAYS = 397

CellToCertify = Annotated[str, typer.Argument(help="Name of the cell.")]
Folder = Annotated[Path, typer.Option("--dir", help="Where the authority and its certificates are kept.")]
Days = Annotated[int, typer.Option(help="How long the certificates are valid.", min=1, max=3650)]
Hosts = Annotated[
    list[str] | None, typer.Option("--host", help="Name or address under which a site is reached; may be repeated.")
]

certificates_app = typer.Typer(help="Make and renew the certificates that protect the links.", no_args_is_help=True)


@certificates_app.command("create")
def create_command(
    cell: CellToCertify, folder: Folder = Path("certificates"), days: Days = DAYS, host: Hosts = None
) -> None:
    """Make an authority, and its certificates for the sites of a cell, its viewers and its maintenance.

    Example: farhand certificates create lab --host robot.example.org
    """
    from farhand.certificates.folder import CertificateOrder, create, guidance

    create(folder, CertificateOrder(cell, tuple(host or ()), days), datetime.now(UTC))
    typer.echo(guidance(folder, cell, host or ()))


@certificates_app.command("renew")
def renew_command(
    cell: CellToCertify, folder: Folder = Path("certificates"), days: Days = DAYS, host: Hosts = None
) -> None:
    """Make new keys and certificates of the same authority for the same hosts; a host given here is added.

    Example: farhand certificates renew lab
    """
    from farhand.certificates.folder import CertificateOrder, renew

    made = renew(folder, CertificateOrder(cell, tuple(host or ()), days), datetime.now(UTC))
    typer.echo(f"renewed for {days} days: {', '.join(str(path) for path in made)}, and their keys")
    typer.echo("copy each pair to its host and restart the services there; the old ones are good until they expire")
